#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/room/base/latency.h"
#include "apps/room/base/playback_options.h"
#include "apps/room/frames/frame_view.h"
#include "apps/room/frames/play_controls.h"
#include "apps/room/frames/signals.h"
#include "apps/room/live/monitor.h"
#include "aula/devices/device.h"
#include "aula/devices/scene_player.h"
#include "aula/engine/propagation.h"
#include "aula/engine/scene.h"

namespace aula {

/// A snapshot of a player.
struct PlayStatus : ScenePlayerStatus {
    double scene_time_s = 0;            ///< time played since the start of the scene
    FrameStatistics frame;              ///< of the newest frame
    int full_rays = 0;                  ///< rays per source without a reduction
    double full_response_length_s = 0;  ///< without a reduction
    double load = 0;                    ///< share of a block's duration that the audio thread needs
    double mean_load = 0;
    double worst_load = 0;
    std::uint64_t rendering_underruns = 0;  ///< underruns caused by rendering that took too long
    std::vector<Underrun> first_underruns;  ///< times and causes of the first ones
    bool realtime = true;                   ///< the audio thread has real-time priority
    std::uint64_t reconnects = 0;           ///< number of reconnections of the device
    PoseLatency latency;
    float limiter_gain = 1;  ///< least gain of the limiter since the last status()
    std::uint64_t failed_changes = 0;
};

/// Plays a scene on an output device: an Auralizer on the real-time clock, the device with its
/// audio thread, and a thread that prepares changes. If frames take longer than their period, it
/// lowers the rays (PlaybackOptions::rays_fall) and the length of the responses (where the scene
/// does not set it) until they do not (LiveLoad). Sound starts in the constructor; it fades out and
/// stops in the destructor. If the device returns from a loss with another sample rate, what plays
/// is prepared for it as by change(). The pose of a path takes effect one frame after its time, a
/// turn of the head in the next block.
class Player {
 public:
    /// Keeps a copy of the scene. If the device refuses the sample rate, the device's rate is used.
    /// Throws InputError, Failure.
    Player(const Scene& scene, const PlaybackOptions& options);
    ~Player();
    Player(const Player&) = delete;
    Player& operator=(const Player&) = delete;

    /// Sets the listener's pose if the scene gives it no path. [any thread]
    void move_listener(const Pose& pose);

    /// Sets the controls from the next frame on. [any thread]
    void control(const PlayControls& controls);
    PlayControls controls() const;

    /// Changes the controls atomically; `change` receives the listener's present pose. [any thread]
    void adjust(const std::function<void(PlayControls&, const Pose& listener)>& change);

    /// Positions of the sources in the newest frame. [any thread]
    std::vector<Vec3> source_positions() const;

    /// Continues with another scene or other options. They are prepared in the background during
    /// playback, then crossfaded to. Of several changes in a row the newest is made. The time
    /// continues, or begins anew with default controls. The device, its sample rate, block and
    /// output do not change. Errors are reported in status(); playback continues. Returns the
    /// change's number (>= 1). [any thread]
    std::uint64_t change(const Scene& scene, const PlaybackOptions& options,
                         bool starts_anew = false);

    /// Plays another signal on a source until a change replaces it. [any thread]
    void play_signal(std::size_t source, std::shared_ptr<const Signal> signal);

    /// Starts or stops copying the requested data of frames for display. [any thread]
    void watch(const std::optional<ViewRequest>& request);

    /// The newest copy; null before the first. Copies are made between two frames, and rarely if
    /// there is no time between them. [any thread]
    std::shared_ptr<const FrameView> view() const;

    /// Starts measuring the loudness. [one thread]
    void measure_loudness();

    /// Records the output to a WAV file until stop_recording(). Throws InputError. [one thread]
    void record(const std::filesystem::path& file);
    void stop_recording();

    /// Loudness and recording. [one thread]
    MonitorStatus monitor_status();

    /// Throws Failure if the device is lost and was not available again in time. Rethrows errors of
    /// the propagation thread.
    PlayStatus status();

    const DeviceInfo& device() const;
    /// The present one; see ScenePlayerStatus.
    double sample_rate_hz() const;

    /// Warnings about sound files and the device.
    const std::vector<std::string>& warnings() const;

 private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace aula
