#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "apps/plugin/control_snapshot.h"
#include "apps/plugin/ports.h"
#include "apps/session/frames/ray_load.h"
#include "apps/session/live/growing_length.h"
#include "aula/auralizer.h"

namespace aula::plugin {

/// A property of a state that this version of the plugin does not know.
struct UnknownProperty {
    std::string uri;
    std::uint32_t type = 0;  ///< as the host maps it
    std::uint32_t flags = 0;
    std::vector<char> value;
};

/// What the state of a plugin holds beside its ports.
struct RoomFiles {
    std::filesystem::path scene{};        ///< empty: the default room
    std::filesystem::path hrtf{};         ///< empty: MIT KEMAR
    std::optional<std::uint64_t> seed{};  ///< in place of the scene's
    std::vector<UnknownProperty> unknown{};
};

/// The scene of files, with the first of its sources only, without paths; the default room if it
/// has no source. Throws InputError.
Scene plugin_scene(const RoomFiles& files);

/// What the values of controls mean in a scene.
class SceneControls {
 public:
    explicit SceneControls(const Scene& scene);

    /// Places whose ports have their initial values are those of the scene.
    Pose source_pose(const ControlValues& values) const;
    Pose listener_pose(const ControlValues& values) const;

    float gain_db(const ControlValues& values) const;
    int rays(const ControlValues& values) const;
    static PartGains part_gains(const ControlValues& values);

 private:
    Pose scene_source_;
    Pose scene_listener_;
    float scene_gain_db_;
    int scene_rays_;
};

/// The values of all control ports that hosts have not changed.
ControlValues initial_values();

/// Applies the values of controls to the room of an auralizer. Only what has changed is set.
class ControlFollower {
 public:
    explicit ControlFollower(const Scene& scene);

    /// The changes take effect as soon as possible.
    void follow(Auralizer& auralizer, const ControlValues& values);

    int rays(const ControlValues& values) const { return controls_.rays(values); }

 private:
    SceneControls controls_;
    ControlValues applied_;
};

/// A room with a source and a listener, as a plugin plays it.
class PluginRoom {
 public:
    PluginRoom() = default;
    virtual ~PluginRoom() = default;
    PluginRoom(const PluginRoom&) = delete;
    PluginRoom& operator=(const PluginRoom&) = delete;

    /// Renders any number of samples. [audio thread; waits on the exact clock]
    virtual void render(const float* input, std::span<float* const> outputs, int samples) = 0;

    /// How long it is heard after its input has ended. [audio thread]
    virtual std::int64_t tail_samples() const = 0;
};

/// The outputs of a plugin.
struct PluginOutput {
    OutputFormat format = OutputFormat::binaural;
    double sample_rate_hz = 48000;
    int block = 256;  ///< samples of most calls
};

/// A room of one instance.
class OwnRoom final : public PluginRoom {
 public:
    /// On the exact clock, without latency; set_controls() sets the controls. Throws InputError.
    OwnRoom(const Scene& scene, const std::filesystem::path& hrtf, const PluginOutput& output);
    /// On the real-time clock: the frames follow `controls`, with as many rays as are computed in
    /// time. `report` is called on the propagation thread, and `replace` once when the responses
    /// are to have another length.
    OwnRoom(const Scene& scene, const std::filesystem::path& hrtf, const PluginOutput& output,
            std::shared_ptr<const ControlSnapshot> controls, const ReportRays& report,
            std::shared_ptr<GrowingLength> length, std::function<void()> replace);

    /// On the exact clock: the values from the next sample on.
    void set_controls(const ControlValues& values) { follower_.follow(auralizer_, values); }

    /// Waits until a frame is heard, at most a few seconds. [real-time clock]
    void wait_for_frame() const;

    void render(const float* input, std::span<float* const> outputs, int samples) override;
    std::int64_t tail_samples() const override { return auralizer_.tail_samples(); }

 private:
    std::shared_ptr<GrowingLength> length_;
    std::shared_ptr<void> heard_;
    ControlFollower follower_;
    Auralizer auralizer_;
};

}  // namespace aula::plugin
