#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "apps/plugin/control_snapshot.h"
#include "apps/plugin/controls.h"
#include "apps/room/frames/ray_load.h"
#include "apps/room/live/growing_length.h"
#include "aula/auralizer.h"

namespace aula::plugin {

/// What the state of a plugin holds beside its controls.
struct RoomFiles {
    std::filesystem::path scene{};        ///< empty: the default room
    std::filesystem::path hrtf{};         ///< empty: MIT KEMAR
    std::optional<std::uint64_t> seed{};  ///< in place of the scene's
};

/// The scene of files, with the first of its sources only, without paths; the default room if it
/// has no source. Throws InputError.
Scene plugin_scene(const RoomFiles& files);

/// The most inputs of a plugin: each is a source.
inline constexpr std::size_t kMostSources = 2;

/// Of the source of an input.
inline SourceId source_id(std::size_t input) { return SourceId{input + 1}; }

/// What the values of controls mean in a scene of plugin_scene().
class SceneControls {
 public:
    SceneControls(const Scene& scene, std::size_t sources);

    std::size_t sources() const { return sources_; }

    /// Places whose controls have their initial values are those of the scene. Shares of the room
    /// move a place towards an end of the room's box. Two sources are a metre apart, the first one
    /// on the left for a listener who looks along X.
    Pose source_pose(const ControlValues& values, std::size_t source) const;
    Pose listener_pose(const ControlValues& values) const;

    /// The controls, from the shares of the room on, that move the source or the listener to a
    /// place in the room; without geometry those in metres. `first`: source_x or listener_x.
    std::array<std::pair<Control, float>, 3> moved_to(const Vec3& place, Control first,
                                                      const ControlValues& values) const;

    float gain_db(const ControlValues& values) const;
    int rays(const ControlValues& values) const;
    static PartGains part_gains(const ControlValues& values);

 private:
    bool has_room() const { return room_.min.x <= room_.max.x; }
    Vec3 in_metres(const ControlValues& values, Control first) const;
    Vec3 in_room(Vec3 place, const ControlValues& values, Control first) const;

    std::size_t sources_;
    Bounds room_;  ///< of all geometry
    Pose scene_source_;
    Pose scene_listener_;
    float scene_gain_db_;
    int scene_rays_;
};

/// The values of all controls that hosts have not changed.
ControlValues initial_values();

/// Applies the values of controls to the room of an auralizer. Only what has changed is set.
class ControlFollower {
 public:
    ControlFollower(const Scene& scene, std::size_t sources);

    /// The changes take effect as soon as possible.
    void follow(Auralizer& auralizer, const ControlValues& values);

    int rays(const ControlValues& values) const { return controls_.rays(values); }

 private:
    SceneControls controls_;
    ControlValues applied_;
};

/// A room with a source for each input and a listener, as a plugin plays it.
class PluginRoom {
 public:
    PluginRoom() = default;
    virtual ~PluginRoom() = default;
    PluginRoom(const PluginRoom&) = delete;
    PluginRoom& operator=(const PluginRoom&) = delete;

    /// Renders any number of samples. [audio thread; waits on the exact clock]
    virtual void render(std::span<const float* const> inputs, std::span<float* const> outputs,
                        int samples) = 0;

    /// How long it is heard after its input has ended. [audio thread]
    virtual std::int64_t tail_samples() const = 0;
};

/// The inputs and outputs of a plugin.
struct PluginPorts : OutputOptions {
    std::size_t sources = 1;         ///< inputs, up to kMostSources
    std::filesystem::path folder{};  ///< of the scenes that ship with the plugins
};

/// A room of one instance.
class OwnRoom final : public PluginRoom {
 public:
    /// On the exact clock, without latency; set_controls() sets the controls. Throws InputError.
    OwnRoom(const Scene& scene, const PluginPorts& ports);
    /// On the real-time clock: the frames follow `controls`, with as many rays as are computed in
    /// time. `report` is called on the propagation thread, and `replace` once when the responses
    /// are to have another length.
    OwnRoom(const Scene& scene, const PluginPorts& ports,
            std::shared_ptr<const ControlSnapshot> controls, const ReportRays& report,
            std::shared_ptr<GrowingLength> length, std::function<void()> replace);

    /// On the exact clock: the values from the next sample on.
    void set_controls(const ControlValues& values) { follower_.follow(auralizer_, values); }

    /// Waits until a frame is heard, at most a few seconds. [real-time clock]
    void wait_for_frame() const;

    void render(std::span<const float* const> inputs, std::span<float* const> outputs,
                int samples) override;
    std::int64_t tail_samples() const override { return auralizer_.tail_samples(); }

    OwnRoom* discarded_before = nullptr;  ///< links the rooms that a RoomLoader is to destroy

 private:
    std::shared_ptr<GrowingLength> length_;
    std::shared_ptr<void> heard_;
    ControlFollower follower_;
    Auralizer auralizer_;
};

}  // namespace aula::plugin
