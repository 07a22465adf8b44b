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

#include "aula/audio/output_format.h"
#include "aula/audio/realtime.h"
#include "aula/engine/scene.h"

namespace aula {

/// When propagation frames are computed, and when changes take effect.
enum class RenderClock {
    /// The audio thread never waits. Frames are computed at regular wall-clock times and the newest
    /// one is heard. A change takes effect as early as possible.
    real_time,
    /// render() waits for the frame of its sample time. The same changes give the same bytes for
    /// any sequence of block sizes and any number of threads.
    exact,
};

/// Identifies a source of an Auralizer. No source has the number 0.
struct SourceId {
    std::uint64_t number = 0;
    friend bool operator==(const SourceId&, const SourceId&) = default;
};

/// Sample time of a change that takes effect as early as possible.
inline constexpr std::int64_t kNow = std::numeric_limits<std::int64_t>::min();

class Auralizer;

struct AuralizerOptions {
    RenderClock clock = RenderClock::real_time;
    double sample_rate_hz = 48000;
    /// Samples processed together on the real-time clock, best the size of most calls. Longer calls
    /// are divided; shorter ones cost more per sample. The exact clock ignores it.
    int block = 256;
    OutputFormat output = OutputFormat::binaural;
    int ambisonic_order = 1;           ///< of the reverberation in binaural output, 1 to 3
    std::filesystem::path hrtf;        ///< SOFA file; empty: libmysofa's default
    bool half_precision_tail = false;  ///< late reverberation in half the memory, error -74 dB
    std::size_t listeners = 1;
    std::size_t most_sources = 16;  ///< present together; at least as many as the scene has
    /// Called before each frame with the frame's time. Poses set in the call, orientations of heads
    /// included, belong to that frame. [propagation thread]
    std::function<void(Auralizer&, double time_s)> before_frame;
};

/// An omnidirectional source to add.
struct NewSource {
    Vec3 position{0};
    float gain_db = 0;
    /// Seeds the noise carriers of its reverberation: sources with equal names have equal carriers.
    /// Empty: seeded by the source's number.
    std::string name{};
};

/// Input samples of a source in one call of render().
struct SourceSignal {
    SourceId source;
    const float* samples = nullptr;
};

struct AuralizerStatus {
    std::int64_t samples = 0;       ///< rendered
    bool paused = false;            ///< the fade to silence is complete
    std::uint64_t frames = 0;       ///< propagation frames
    std::uint64_t late_frames = 0;  ///< frame times missed while a frame was computed
    double frame_ms = 0;            ///< computation time of the newest frame
    double frame_mean_ms = 0;
    double frame_worst_ms = 0;
    double frame_period_ms = 0;
    double response_length_s = 0;
    std::size_t memory_bytes = 0;  ///< of the propagation's caches
};

/// A room made audible block by block, without device and files: the propagation on its own thread
/// and a renderer for each listener. While it plays, sources can be added, removed and moved,
/// listeners and objects moved and materials changed, without a click.
///
/// Propagation frame k is at time k / Simulation::frame_rate_hz. Turns of a head, additions and
/// removals take effect at the sample time of the change; all other changes in the first frame at
/// or after it.
///
/// On the exact clock a change without a sample time, or with a past one, has that of the next
/// sample to render, or that of the last commit() where it is later; a change of a source that has
/// not begun has that of its beginning. The real-time clock ignores sample times.
///
/// Commands lock: any thread may call them except, on the real-time clock, the thread that renders.
/// Started threads have ordinary priority and end with the destructor.
class Auralizer {
 public:
    /// Copies the scene and adds its sources. Their paths are not followed (see follow_paths()) and
    /// their signals not read. Throws InputError.
    explicit Auralizer(const Scene& scene, AuralizerOptions options = {});
    ~Auralizer();
    Auralizer(const Auralizer&) = delete;
    Auralizer& operator=(const Auralizer&) = delete;

    /// Adds a source. It is heard from its first frame on; on the real-time clock after at most two
    /// frames. After the first sample a source fades in over 20 ms. Throws InputError for more than
    /// AuralizerOptions::most_sources.
    SourceId add_source(const NewSource& source, std::int64_t at = kNow);

    /// Fades a source out over 20 ms, during which its signal should continue. Its reverberation
    /// decays naturally.
    void remove_source(SourceId source, std::int64_t at = kNow);

    /// All present sources in the order of their addition, those of the scene first.
    std::vector<SourceId> sources() const;

    /// Moves a source; its orientation is ignored. Throws InputError if the position is not finite.
    void set_source(SourceId source, const Pose& pose, std::int64_t at = kNow);

    /// Throws InputError for more than 120 dB.
    void set_gain(SourceId source, float gain_db, std::int64_t at = kNow);
    void set_listener(const Pose& pose, std::int64_t at = kNow) { set_listener(0, pose, at); }
    void set_listener(std::size_t listener, const Pose& pose, std::int64_t at = kNow);

    /// Moves an object, given by its index in Scene::objects. Throws InputError if it is not
    /// movable or the transform is not rigid.
    void set_transform(std::size_t object, const RigidTransform& transform, std::int64_t at = kNow);

    /// Assigns a material to an object, by the name of one of the scene or the library. Responses
    /// keep their length. Throws InputError for an unknown name.
    void set_material(std::size_t object, const std::string& name, std::int64_t at = kNow);
    void set_material(std::size_t object, const Material& material, std::int64_t at = kNow);

    /// Declares that all changes before a sample time have been made, so that frames up to there
    /// are computed ahead. Without it a frame is computed when render() reaches it. [exact clock]
    void commit(std::int64_t until);

    /// Fades out over 20 ms, then stops the sample time. resume() continues it and fades in.
    void pause();
    void resume();

    /// Renders any number of samples. A source without a signal is silent; of several signals of
    /// one source the first counts; signals of absent sources are ignored. Overwrites `outputs`:
    /// output_channels() signals, [listener][channel], which lag the inputs by latency_samples().
    /// Throws InputError for another number of outputs; on the exact clock rethrows errors of the
    /// propagation.
    /// [real time: audio thread, wait-free; exact: any one thread, waits]
    void render(std::span<const SourceSignal> inputs, std::span<float* const> outputs, int samples);

    std::size_t output_channels() const;
    int latency_samples() const;
    double sample_rate_hz() const;
    double response_length_s() const;

    /// How long a source is heard after its signal has ended.
    std::int64_t tail_samples() const;

    /// Impulse response of a source in the newest frame, gains included: [channel][sample], sample
    /// 0 is emission. Empty before the first frame of the source. Waits for the frame in progress.
    std::vector<std::vector<float>> impulse_response(SourceId source,
                                                     std::size_t listener = 0) const;

    /// True if no surface lies between a source and a listener in the newest frame; always false
    /// if Simulation::direct is false.
    bool visible(SourceId source, std::size_t listener = 0) const;

    /// Rethrows errors of the propagation thread.
    AuralizerStatus status() const;

 private:
    struct State;
    std::unique_ptr<State> state_;
};

/// An AuralizerOptions::before_frame that moves those of the scene's initial sources, its listener
/// and its objects that have a path along it.
std::function<void(Auralizer&, double time_s)> follow_paths(const Scene& scene);

}  // namespace aula
