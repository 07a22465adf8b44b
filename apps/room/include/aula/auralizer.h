#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "aula/audio/output_options.h"
#include "aula/audio/realtime.h"
#include "aula/engine/scene.h"

namespace aula {

/// When propagation frames are computed, and when changes take effect.
enum class RenderClock {
    /// render() never waits. Frames are computed at regular wall-clock times and the newest one is
    /// heard. A change takes effect as early as possible.
    real_time,
    /// render() waits for the frame of its sample time. A change takes effect at its sample time.
    /// The same changes and signals give the same bytes for any sequence of block sizes and any
    /// number of threads.
    exact,
};

/// Identifies a source of an Auralizer.
struct SourceId {
    /// Counts from 1, for sources added in AuralizerOptions::before_frame from 2^32 + 1; never
    /// reused. 0: no source.
    std::uint64_t number = 0;
    /// True for the same source.
    friend bool operator==(const SourceId&, const SourceId&) = default;
};

/// Sample time of a change that takes effect as early as possible: the default of all commands.
inline constexpr std::int64_t kNow = std::numeric_limits<std::int64_t>::min();

class Auralizer;
class LiveAuralizer;

/// The settings of an Auralizer. They do not change during its life. The exact clock ignores
/// OutputOptions::block.
struct AuralizerOptions : OutputOptions {
    RenderClock clock = RenderClock::real_time;  ///< exact for files and tests
    /// Exact clock only: renders sample by sample without latency, at several times the cost.
    bool sample_by_sample = false;
    std::size_t listeners = 1;  ///< number of listeners, at least 1; indices from 0
    /// Largest number of sources that are present at the same time; at least that of the scene is
    /// used.
    std::size_t max_sources = 16;
    /// Bytes that the renderers may take when they are constructed: some MB for each of max_sources
    /// at each listener. More is an InputError that has their number. The filters of the sources
    /// that are present come in addition. 4 GiB, half of the memory of an ordinary machine. After
    /// set_scene() each scene that sounds has as many: up to four.
    std::uint64_t max_memory_bytes = std::uint64_t{1} << 32;
    /// Called on the propagation thread before each frame, with the object and the frame's time in
    /// s. Poses that are set in the call, orientations of heads included, belong to that frame.
    /// Empty: no call.
    std::function<void(Auralizer&, double time_s)> before_frame{};
};

/// A source to add.
struct NewSource {
    Vec3 position{0};           ///< m, world axes
    float yaw_rad = 0;          ///< orientation as in Pose
    float pitch_rad = 0;        ///< orientation as in Pose
    float roll_rad = 0;         ///< orientation as in Pose
    Directivity directivity{};  ///< in the local axes of the source
    float gain_db = 0;          ///< at most 200; -infinity mutes
    /// Seeds the noise of its reverberation: sources of equal names have correlated reverberation.
    /// Empty: the source's number is the seed.
    std::string name{};
};

/// Input samples of a source in one call of render().
struct SourceSignal {
    SourceId source;  ///< the source that plays them
    /// As many samples as the call renders. 1.0 of an omnidirectional source has the amplitude 1.0
    /// at a distance of 1 m in a free field. Null: silence.
    const float* samples = nullptr;
};

/// Linear gains of the parts of the sound, from 0 on.
struct PartGains {
    float direct = 1;  ///< of the direct sound
    float early = 1;   ///< of specular reflections
    float late = 1;    ///< of all other reverberation
};

/// The state and the load of an Auralizer.
struct AuralizerStatus {
    std::int64_t samples = 0;          ///< sample time: samples rendered, without pauses
    bool paused = false;               ///< true from the end of the fade to a pause on
    std::uint64_t frames = 0;          ///< propagation frames computed
    std::uint64_t late_frames = 0;     ///< frames that took longer than frame_period_ms
    std::uint64_t skipped_frames = 0;  ///< frame times skipped because of late frames (real time)
    double frame_ms = 0;               ///< computation time of the newest frame
    double frame_mean_ms = 0;          ///< mean computation time of all frames
    double frame_worst_ms = 0;         ///< longest computation time of all frames
    double counted_mean_ms = 0;        ///< mean time of all frames as counted from their work, on
                                       ///< one processor: the same on all machines
    double frame_period_ms = 0;        ///< time between frames; in real time frame_ms must be below
    double frame_age_s = 0;            ///< time since the newest frame reached render() (real time)
    int rays = 0;                      ///< rays per source in the newest frame
    double response_length_s = 0;      ///< as Auralizer::response_length_s()
    std::size_t memory_bytes = 0;      ///< memory of the propagation's caches
    /// Samples of inputs and outputs that were not finite or beyond 1e6; they are silence.
    std::int64_t muted_samples = 0;
    std::size_t silent_pairs = 0;  ///< pairs of a source and a listener with Auralizer::silent()
};

/// Renders what listeners hear in a room, block by block, without device and files. It computes the
/// propagation on a separate thread and has a renderer for each listener. During rendering sources
/// can be added, removed and moved, listeners and objects moved, materials changed and the scene
/// exchanged, without a click.
///
/// **Sample time** counts the rendered samples from 0 on. The parameter `at` of a command is the
/// sample time at which the change takes effect on the exact clock. The real-time clock ignores it.
/// If `at` is kNow or has passed, the change takes effect at the next sample to render, or at the
/// time of the last commit() if that is later. A change of a source that has not begun takes effect
/// when the source begins.
///
/// **Frames**: propagation frame k of a scene is k / Simulation::frame_rate_hz after its first one,
/// which for the scene of the constructor is at the time 0. Orientations of heads, additions and
/// removals take effect at the sample time of the change. All other changes take effect in the
/// first frame at or after it.
///
/// **Threads**: commands lock a mutex for a short time, except set_scene(), which builds a scene.
/// Any thread may call them, but on the real-time clock the thread that renders must not. Threads
/// that the object starts have ordinary priority, on the real-time clock a nice value of at least
/// kPropagationNice from the second frame on. They end with the destructor.
///
/// **Errors**: wrong arguments throw InputError and change nothing. Commands for a source that is
/// not present have no effect, nor do commands after an exception of the propagation thread;
/// add_source() then returns no source.
class Auralizer {
 public:
    /// Copies the scene, adds its sources and prepares all memory for rendering. The scene's
    /// listener is the initial pose of all listeners. Paths are not followed (see follow_paths()),
    /// and signals of sources are not read. Throws InputError for invalid options, settings or HRTF
    /// files.
    explicit Auralizer(const Scene& scene, AuralizerOptions options = {});
    /// Waits for the frame in progress and ends all threads. No other call may be in progress.
    ~Auralizer();
    Auralizer(const Auralizer&) = delete;
    Auralizer& operator=(const Auralizer&) = delete;

    /// Exchanges the scene: its surfaces, materials, objects and medium, and the settings of its
    /// simulation. Sources and listeners stay with their poses and gains; those of `scene` are
    /// the places for which it is prepared. The number of rays, and poses and materials of objects,
    /// are those of `scene`; commands for objects of the present scene have no effect in it. The
    /// inputs fade from the present scene to the next one over 50 ms, while the present one rings
    /// out. Of three that ring out the oldest fades out first; on the exact clock it ends at once
    /// if it still does when a further scene begins.
    ///
    /// Copies the scene, and returns when it is built; rendering goes on meanwhile. It begins with
    /// the first frame at or after `at`, on the real-time clock with the next frame. Commands for
    /// objects refer to the scene at their time, on the real-time clock after this call to `scene`.
    /// Takes as long as the constructor; several calls at a time follow each other. Throws
    /// InputError for invalid settings, which changes nothing.
    void set_scene(const Scene& scene, std::int64_t at = kNow);

    /// The scene to which commands refer that are called now.
    std::shared_ptr<const Scene> scene() const;

    /// Adds a source. It is heard from its first frame on; on the real-time clock after at most two
    /// frames. It fades in over 20 ms unless it begins at the first sample. If all places are taken
    /// by sources and by reverberation of removed sources, the oldest such reverberation ends, and
    /// the source begins when its slot has been silent for a frame.
    /// Throws InputError for more than AuralizerOptions::max_sources sources.
    SourceId add_source(const NewSource& source, std::int64_t at = kNow);

    /// Fades a source out over 20 ms, during which its signal should continue. Its reverberation
    /// decays naturally.
    void remove_source(SourceId source, std::int64_t at = kNow);

    /// All present sources in the order of their addition, those of the scene first.
    std::vector<SourceId> sources() const;

    /// Moves and turns a source. Between frames the delay and the gains of its paths change
    /// uniformly. Throws InputError if the pose is not finite.
    void set_source(SourceId source, const Pose& pose, std::int64_t at = kNow);

    /// Sets the gain of a source in dB; -infinity mutes it. Throws InputError above 200 dB.
    void set_gain(SourceId source, float gain_db, std::int64_t at = kNow);

    /// Moves and turns listener 0.
    void set_listener(const Pose& pose, std::int64_t at = kNow) { set_listener(0, pose, at); }

    /// Moves and turns a listener, given by its index. The head turns uniformly between poses.
    /// Throws InputError if there is no such listener or the pose is not finite.
    void set_listener(std::size_t listener, const Pose& pose, std::int64_t at = kNow);

    /// Sets the gains of direct sound, specular reflections and other reverberation for all
    /// sources. Throws InputError if a gain is negative or not finite.
    void set_part_gains(const PartGains& gains, std::int64_t at = kNow);

    /// Sets the rays per source and frame, in place of Simulation::rays. Throws InputError
    /// unless they are 1 to Simulation::kMaxRays.
    void set_rays(int rays, std::int64_t at = kNow);

    /// Adapts the rays until set_rays(), so that the computation of a frame takes this share of the
    /// frame period. Throws InputError if the share is negative or not finite, and on the exact
    /// clock.
    void set_frame_share(double share);

    /// Moves an object, given by its index in Scene::objects. The transform applies to the object's
    /// vertices and replaces the earlier transform. Throws InputError if there is no such object,
    /// if it is not movable (Object::movable), or if the transform is not rigid and finite.
    void set_transform(std::size_t object, const RigidTransform& transform, std::int64_t at = kNow);

    /// Moves an object, given by its name: the first one of this name in the scene to which the
    /// command refers. While another thread calls set_scene(), an index may be that of another
    /// object; a name is not.
    void set_transform(const std::string& object, const RigidTransform& transform,
                       std::int64_t at = kNow);

    /// Assigns a material to all triangles of an object, by the name of one of the scene or the
    /// library. The response length does not change. Throws InputError for an unknown object or
    /// name.
    void set_material(std::size_t object, const std::string& name, std::int64_t at = kNow);

    /// Assigns a material that need not be in the scene. Throws InputError for an unknown object,
    /// or if a coefficient is not from 0 to 1.
    void set_material(std::size_t object, const Material& material, std::int64_t at = kNow);

    /// Assigns a material by its name to an object that is given by its name; see set_transform().
    void set_material(const std::string& object, const std::string& name, std::int64_t at = kNow);

    /// Assigns a material to an object that is given by its name; see set_transform().
    void set_material(const std::string& object, const Material& material, std::int64_t at = kNow);

    /// Declares that all changes before the sample time `until` have been made. Frames before it
    /// are then computed ahead, in parallel with rendering. Without it a frame is computed when
    /// render() reaches its time. No effect on the real-time clock.
    void commit(std::int64_t until);

    /// Fades out over 20 ms, then stops the sample time; render() then writes silence. Wait-free;
    /// any thread may call it.
    void pause();

    /// Continues the sample time after a pause, and fades in over 20 ms. Wait-free; any thread may
    /// call it.
    void resume();

    /// Renders any number of samples. A source without a signal is silent. Of several signals of
    /// one source the first counts. Signals of absent sources are ignored. Samples of inputs and
    /// outputs that are not finite, or beyond 1e6 in magnitude, are silence
    /// (AuralizerStatus::muted_samples).
    ///
    /// Overwrites `outputs`, output_channels() pointers to `samples` samples each: all channels of
    /// listener 0, then those of listener 1, and so on. Outputs lag the inputs by
    /// latency_samples().
    ///
    /// Throws InputError for another number of outputs. On the exact clock it rethrows exceptions
    /// of the propagation thread. [real time: one thread, wait-free; exact: one thread, waits]
    void render(std::span<const SourceSignal> inputs, std::span<float* const> outputs, int samples);

    /// Number of outputs of render(): channel_count() of the output format for each listener.
    /// Constant, as are the two values below; any thread may ask for them.
    std::size_t output_channels() const;

    /// Delay from the inputs to the outputs of render(): 0 on the real-time clock, 256 on the exact
    /// clock, 0 there with AuralizerOptions::sample_by_sample. The delay of sound in the air comes
    /// in addition.
    int latency_samples() const;

    /// AuralizerOptions::sample_rate_hz.
    double sample_rate_hz() const;

    /// Length of the responses of the newest frame's scene: see Propagation::response_length_s().
    /// It and the two values below lock a mutex, as commands do.
    double response_length_s() const;

    /// The same with the filter of AuralizerOptions::headphones, which comes after the room.
    double heard_length_s() const;

    /// That of the newest frame's scene: see Propagation::patch_size_m.
    float patch_size_m() const;

    /// How long sources are heard after their signals have ended: the response length, or the
    /// longest path of the frame that is heard, and 0.1 s for fades and filters; at least as long
    /// as an earlier scene rings out. An upper bound before the first frame. Any thread may ask for
    /// it.
    std::int64_t tail_samples() const;

    /// Impulse response of a source at a listener in the newest frame, as it is heard with its gain
    /// and the head's orientation: [channel][sample] in the output format. Sample 0 is the
    /// emission. Empty before the first frame of the source, or if there is no such source or
    /// listener. Waits for the frame in progress and allocates.
    std::vector<std::vector<float>> impulse_response(SourceId source,
                                                     std::size_t listener = 0) const;

    /// True if no surface lies between a source and a listener in the newest frame. False if there
    /// is no such source or listener, and always if Simulation::direct is false.
    bool visible(SourceId source, std::size_t listener = 0) const;

    /// True if nothing of a source has reached a listener in the frames of half a second, whatever
    /// its signal and gain: one of the two may be outside of the room, or inside of an object.
    /// False if there is no such source or listener.
    bool silent(SourceId source, std::size_t listener = 0) const;

    /// The current state. Rethrows the exception that has ended the propagation thread.
    AuralizerStatus status() const;

 private:
    friend class LiveAuralizer;
    struct State;
    Auralizer(const Scene& scene, std::unique_ptr<State> state);

    std::unique_ptr<State> state_;
};

/// A function for AuralizerOptions::before_frame that moves the scene's initial sources, listener 0
/// and the objects of the present scene along their paths, if they have one. It keeps a copy of the
/// scene.
std::function<void(Auralizer&, double time_s)> follow_paths(const Scene& scene);

}  // namespace aula
