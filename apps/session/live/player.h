#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/session/base/latency.h"
#include "apps/session/base/session_options.h"
#include "apps/session/frames/frame_view.h"
#include "apps/session/frames/play_controls.h"
#include "apps/session/frames/signals.h"
#include "apps/session/live/monitor.h"
#include "aula/devices/device.h"
#include "aula/engine/propagation.h"
#include "aula/engine/scene.h"

namespace aula {

/// A snapshot of a player.
struct PlayStatus {
    double time_s = 0;              ///< sound played so far
    double scene_time_s = 0;        ///< of it, since the scene began
    Pose listener;                  ///< of the newest frame
    std::vector<Vec3> sources;      ///< where they were in the newest frame
    std::uint64_t frames = 0;       ///< propagation frames
    std::uint64_t late_frames = 0;  ///< frame times that passed while an earlier frame was computed
    double frame_mean_ms = 0;
    double frame_worst_ms = 0;
    double frame_ms = 0;    ///< of the newest frame
    FrameStatistics frame;  ///< of the newest frame
    int rays = 0;           ///< per source, of the newest frame
    int full_rays = 0;      ///< that it would have if it kept up with them
    double response_length_s = 0;
    double full_response_length_s = 0;  ///< that it would have if it kept up with it
    double response_age_s = 0;          ///< since the newest response was handed over
    double load = 0;                    ///< share of a block's time that the audio thread needs
    double mean_load = 0;
    double worst_load = 0;
    std::uint64_t underruns = 0;
    std::uint64_t rendering_underruns = 0;  ///< of these: rendering took too long
    std::vector<Underrun> first_underruns;  ///< when they were, as many as are kept
    bool realtime = true;                   ///< the audio thread has real-time priority
    DeviceState device = DeviceState::playing;
    std::uint64_t reconnects = 0;  ///< how often the device came back
    PoseLatency latency;
    std::int64_t muted_samples = 0;  ///< of all channels, that were not finite
    float peak = 0;                  ///< largest sample since the last status()
    float limiter_gain = 1;          ///< least gain of the limiter since the last status()
    bool preparing = false;          ///< a change is on its way
    std::uint64_t heard_change = 0;  ///< number of the change that is heard; 0 before the first
    std::string change_error;        ///< why the last change was not made; empty if it was
    std::uint64_t failed_changes = 0;
    bool finished = false;  ///< played to the end
};

/// Plays a scene on an output device: an Auralizer on the real-time clock, the device with its
/// audio thread, and a thread that prepares changes. If frames take longer than their period, it
/// lowers the rays (SessionOptions::rays_fall) and the length of the responses (where the scene
/// does not set it) until they do not (LiveLoad). Sound starts in the constructor; it fades out and
/// stops in the destructor. The pose of a path is heard one frame after its time; a turn of the
/// head from the next block on.
class Player {
 public:
    /// Keeps a copy of the scene. If the device refuses the sample rate its own is used. Throws
    /// InputError, InputError, Failure.
    Player(const Scene& scene, const SessionOptions& options);
    ~Player();
    Player(const Player&) = delete;
    Player& operator=(const Player&) = delete;

    /// Where the listener is from now on, if the scene gives it no path. [any thread]
    void move_listener(const Pose& pose);

    /// What is changed from the next frame on. [any thread]
    void control(const PlayControls& controls);
    PlayControls controls() const;

    /// Changes the controls in one go; `change` sees where the listener is. [any thread]
    void adjust(const std::function<void(PlayControls&, const Pose& listener)>& change);

    /// Plays on with another scene or other options, whatever differs: they are prepared in the
    /// background while the sound goes on, then faded to. Of several changes in a row the newest
    /// is made. Time goes on, or begins anew (and controls are back at nothing changed). The
    /// device stays: its name, sample rate, block and output are not changed. What is wrong with a
    /// change is said in the status, and what played plays on. Its number, from 1 on. [any thread]
    std::uint64_t change(const Scene& scene, const SessionOptions& options,
                         bool starts_anew = false);

    /// Plays another signal on a source, until a change gives that source another. [any thread]
    void play_signal(std::size_t source, std::shared_ptr<const Signal> signal);

    /// Has copies made of what a frame is to be looked at, from now on, or no more. [any thread]
    void watch(const std::optional<ViewRequest>& request);

    /// The newest copy; null before the first. Made between two frames, and seldom where there is
    /// no time between them. [any thread]
    std::shared_ptr<const FrameView> view() const;

    /// Measures from now on how loud it is. [one thread]
    void measure_loudness();

    /// Writes what is heard to a WAV file until stop_recording(). Throws InputError.
    /// [one thread]
    void record(const std::filesystem::path& file);
    void stop_recording();

    /// Loudness and recording. [one thread]
    MonitorStatus monitor_status();

    /// Throws Failure if the device is lost and did not come back, and what the propagation
    /// thread threw.
    PlayStatus status();

    const DeviceInfo& device() const;
    double sample_rate_hz() const;

    /// What was odd about sound files and device.
    const std::vector<std::string>& warnings() const;

 private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace aula
