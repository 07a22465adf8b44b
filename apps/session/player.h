#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "apps/session/session_options.h"
#include "audio/device.h"
#include "engine/scene.h"

namespace aula {

/// A snapshot of a player.
struct PlayStatus {
    double time_s = 0;              ///< sound played so far
    Pose listener;                  ///< of the newest frame
    std::uint64_t frames = 0;       ///< propagation frames
    std::uint64_t late_frames = 0;  ///< frame times that passed while an earlier frame was computed
    double frame_mean_ms = 0;
    double frame_worst_ms = 0;
    double load = 0;  ///< share of a block's time that the audio thread needs
    double worst_load = 0;
    std::uint64_t underruns = 0;
    float peak = 0;         ///< largest sample since the last status()
    bool finished = false;  ///< played to the end
};

/// Plays a scene on an output device. Owns the device with its audio thread, which only renders,
/// and the propagation thread, which wakes at each frame time, hands over the frame that it has
/// computed for the one before, takes the newest listener pose and computes the next; a pose is
/// heard one frame after its time. Sound starts with the constructor and stops with the
/// destructor.
class Player {
 public:
    /// Keeps a copy of the scene. If the device refuses the sample rate its own is used. Throws
    /// Error, AudioInputError, AudioFailure.
    Player(const Scene& scene, const SessionOptions& options);
    ~Player();
    Player(const Player&) = delete;
    Player& operator=(const Player&) = delete;

    /// Where the listener is from now on, if the scene gives it no path. [any thread]
    void move_listener(const Pose& pose);

    /// Throws AudioFailure if the device is lost, and what the propagation thread threw.
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
