#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "audio/base/output_format.h"
#include "audio/base/realtime.h"
#include "engine/scene/scene.h"

namespace aula {

/// When propagation frames are computed, and when changes take effect.
enum class RenderClock {
    /// The audio thread never waits. Frames are computed at even times of the clock on the wall,
    /// the newest is heard, and a change takes effect as soon as it can.
    real_time,
    /// render() waits for the frame of its sample time. The same changes give the same bytes for
    /// any sequence of block sizes and any number of threads.
    exact,
};

/// A source of an Auralizer; none has the number 0.
struct SourceId {
    std::uint64_t number = 0;
    friend bool operator==(const SourceId&, const SourceId&) = default;
};

/// A change without a sample time takes effect as soon as it can.
inline constexpr std::int64_t kNow = std::numeric_limits<std::int64_t>::min();

class Auralizer;

struct AuralizerOptions {
    RenderClock clock = RenderClock::real_time;
    double sample_rate_hz = 48000;
    /// Samples that are processed at a time on the real-time clock: longer calls are divided,
    /// shorter ones cost more per sample. Best is the size of most calls. The exact clock has a
    /// block of its own.
    int block = 256;
    OutputFormat output = OutputFormat::binaural;
    int ambisonic_order = 1;           ///< of the reverberation in binaural output, 1 to 3
    std::filesystem::path hrtf;        ///< SOFA file; empty: libmysofa's default
    bool half_precision_tail = false;  ///< late reverberation in half the memory, error -74 dB
    std::size_t listeners = 1;
    std::size_t most_sources = 16;  ///< at a time; at least as many as the scene has
    /// Called before each frame with its time: poses that are set in it belong to that frame, the
    /// orientations of heads, too. [propagation thread]
    std::function<void(Auralizer&, double time_s)> before_frame;
};

/// A source that is added. Omnidirectional.
struct NewSource {
    Vec3 position{0};
    float gain_db = 0;
    /// Of its reverberation's noise: sources of one name sound alike. Empty: its number.
    std::string name{};
};

/// What a source plays in one call of render().
struct SourceSignal {
    SourceId source;
    const float* samples = nullptr;
};

struct AuralizerStatus {
    std::int64_t samples = 0;       ///< rendered
    bool paused = false;            ///< and faded out
    std::uint64_t frames = 0;       ///< propagation frames
    std::uint64_t late_frames = 0;  ///< frame times that passed while an earlier one was computed
    double frame_ms = 0;            ///< that the newest frame took
    double frame_mean_ms = 0;
    double frame_worst_ms = 0;
    double frame_period_ms = 0;
    double response_length_s = 0;
    std::size_t memory_bytes = 0;  ///< of the propagation's caches
};

/// A room made audible block by block, without a device and without files: the propagation with
/// its thread, and a renderer for each listener. Sources are added and removed, sources, listeners
/// and objects moved, materials changed while it plays, without a click.
///
/// Propagation frames lie at even times, Simulation::frame_rate_hz of them a second, the first at
/// sample 0. Gains, places, objects and materials take effect in a frame; heads turn, and sources
/// begin and end, at the sample of the change. On the exact clock a change with a sample time takes
/// effect there, or in the first frame from there on; one without, or with a time that is past, at
/// the next sample that is rendered. On the real-time clock sample times are ignored.
///
/// The commands may be called by any thread but the one that renders on the real-time clock: they
/// lock. Threads that are started have ordinary priority, and end with the destructor.
class Auralizer {
 public:
    /// Keeps a copy of the scene; its sources are sources(), its paths are not followed (see
    /// follow_paths()), its signals are not read. Throws Error, AudioInputError.
    explicit Auralizer(const Scene& scene, AuralizerOptions options = {});
    ~Auralizer();
    Auralizer(const Auralizer&) = delete;
    Auralizer& operator=(const Auralizer&) = delete;

    /// Adds a source. It is heard from its first frame on, on the real-time clock at most two
    /// frames later. A source that is added after the first sample fades in, for 20 ms. Throws
    /// Error if there are too many.
    SourceId add_source(const NewSource& source, std::int64_t at = kNow);

    /// Fades a source out, for 20 ms, for which its signal should go on; the room rings out.
    void remove_source(SourceId source, std::int64_t at = kNow);

    /// The sources that there are, those of the scene first, in the order in which they were added.
    std::vector<SourceId> sources() const;

    void set_source(SourceId source, const Pose& pose, std::int64_t at = kNow);
    void set_gain(SourceId source, float gain_db, std::int64_t at = kNow);
    void set_listener(const Pose& pose, std::int64_t at = kNow) { set_listener(0, pose, at); }
    void set_listener(std::size_t listener, const Pose& pose, std::int64_t at = kNow);

    /// Moves an object, the one with that index in Scene::objects. Throws Error if it is not
    /// movable.
    void set_transform(std::size_t object, const RigidTransform& transform, std::int64_t at = kNow);

    /// Gives an object another material: one of the scene or, by name, of the library. The
    /// responses keep their length. Throws Error if there is none of that name.
    void set_material(std::size_t object, const std::string& name, std::int64_t at = kNow);
    void set_material(std::size_t object, const Material& material, std::int64_t at = kNow);

    /// Promises that all changes before a sample time have been made: frames are computed ahead, up
    /// to there. Without, a frame is computed when render() has come to it. [exact clock]
    void commit(std::int64_t until);

    /// Fades to silence, where time stands still, and back.
    void pause();
    void resume();

    /// Renders samples, any number. A source without a signal is silent; signals of sources that
    /// there are not are ignored. `outputs`: output_channels() signals, the channels of each
    /// listener together, overwritten. They are latency_samples() behind the inputs. On the exact
    /// clock throws what the propagation threw.
    /// [real time: audio thread, wait-free; exact: any one thread, waits]
    void render(std::span<const SourceSignal> inputs, std::span<float* const> outputs, int samples);

    std::size_t output_channels() const;
    int latency_samples() const;
    double sample_rate_hz() const;
    double response_length_s() const;

    /// For how long a sound is heard after its source has ended.
    std::int64_t tail_samples() const;

    /// The newest frame's impulse response of a source as it is heard: [channel][sample], sample 0
    /// is emission, gains are applied. Empty before the source's first frame.
    std::vector<std::vector<float>> impulse_response(SourceId source,
                                                     std::size_t listener = 0) const;

    /// Whether nothing lies between a source and a listener in the newest frame. False where
    /// Simulation::direct is.
    bool visible(SourceId source, std::size_t listener = 0) const;

    /// Throws what the propagation thread threw.
    AuralizerStatus status() const;

 private:
    struct State;
    std::unique_ptr<State> state_;
};

/// Sets sources, listener and objects to where a scene's paths have them, frame by frame:
/// AuralizerOptions::before_frame for the sources that the scene had at first.
std::function<void(Auralizer&, double time_s)> follow_paths(const Scene& scene);

}  // namespace aula
