#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "aula/audio/output_options.h"
#include "aula/auralizer.h"
#include "aula/devices/device.h"
#include "aula/engine/scene.h"

namespace aula {

/// The settings of a ScenePlayer. They do not change during its life. If the device requires
/// another sample rate, that is used. A block is what one callback of the device asks for.
struct ScenePlayerOptions : OutputOptions {
    std::string device{};                ///< as `wanted` of AudioDevice
    std::optional<double> duration_s{};  ///< if absent: from the scene
    /// Reduces the rays of the scene until frames are computed within their period.
    bool reduces_rays = true;
};

/// The state of a ScenePlayer. Of the members of AuralizerStatus, the numbers and times of frames
/// and the muted samples are those of all scenes so far, the others those of the present scene.
struct ScenePlayerStatus : AuralizerStatus {
    double time_s = 0;                          ///< sound played so far
    bool finished = false;                      ///< true if the scene has been played to its end
    Pose listener;                              ///< pose in the newest frame
    std::vector<Vec3> sources;                  ///< positions in the newest frame
    float peak = 0;                             ///< largest sample since the last status()
    DeviceState device = DeviceState::playing;  ///< state of the output device
    double sample_rate_hz = 0;  ///< of the output; a device may return from a loss with another one
    std::uint64_t underruns = 0;       ///< gaps in the output
    bool preparing = false;            ///< true while a change is being prepared
    std::uint64_t audible_change = 0;  ///< number of the audible change; 0 before the first
    std::string change_error;          ///< error of the last change; empty if it succeeded
};

/// Plays a scene with the signals of its sources on an output device, in the background. Sources,
/// objects and the listener follow their paths. Sound starts in the constructor; it fades out and
/// stops in the destructor. If the device is lost, it is reopened when it is available again, also
/// with another sample rate. All functions but the constructor and the destructor may be called on
/// any thread.
class ScenePlayer {
 public:
    /// Keeps a copy of the scene. Throws InputError for wrong scenes, signals and options, Failure
    /// if the device cannot be opened.
    explicit ScenePlayer(const Scene& scene, const ScenePlayerOptions& options = {});
    ~ScenePlayer();
    ScenePlayer(const ScenePlayer&) = delete;
    ScenePlayer& operator=(const ScenePlayer&) = delete;

    /// Moves the listener; a path of the scene no longer applies. The head turns in the next block.
    void set_listener(const Pose& pose);

    /// Moves a source of the scene, by its index; its path no longer applies.
    void set_source(std::size_t source, const Vec3& position);

    /// Sets the gain of a source of the scene, by its index. -infinity mutes it.
    void set_gain(std::size_t source, float gain_db);

    /// Continues with another scene, which is prepared in the background and then crossfaded to. Of
    /// several changes in a row the newest is made. The time continues, or begins anew without the
    /// poses and gains that were set. An error is reported in status(), and playback continues.
    /// Returns the number of the change (>= 1).
    std::uint64_t change(const Scene& scene, bool starts_anew = false);

    /// The present state. Throws Failure if the device did not return within
    /// AudioDevice::kReconnectTimeout_s or the propagation has failed.
    ScenePlayerStatus status();

    /// The output device.
    const DeviceInfo& device() const;

 private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace aula
