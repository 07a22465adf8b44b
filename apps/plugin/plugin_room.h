#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "apps/plugin/control_snapshot.h"
#include "apps/plugin/ports.h"
#include "aula/auralizer.h"

namespace aula::plugin {

/// What the state of a plugin holds beside its ports.
struct RoomFiles {
    std::filesystem::path scene{};        ///< empty: the default room
    std::filesystem::path hrtf{};         ///< empty: that of libmysofa
    std::optional<std::uint64_t> seed{};  ///< in place of the scene's
};

/// The scene of files, with the first of its sources only, without paths; the default room if it
/// has no source. Throws InputError.
Scene plugin_scene(const RoomFiles& files);

/// Applies the values of controls to the room of an auralizer. Only what has changed is set.
class ControlFollower {
 public:
    explicit ControlFollower(const Scene& scene);

    /// The changes take effect as soon as possible.
    void follow(Auralizer& auralizer, const ControlValues& values);

 private:
    /// Places whose ports have their initial values are those of the scene.
    Pose source_pose(const ControlValues& values) const;
    Pose listener_pose(const ControlValues& values) const;

    Pose scene_source_;
    Pose scene_listener_;
    float scene_gain_db_;
    int scene_rays_;
    ControlValues applied_;
};

/// A room with a source and a listener, as a plugin plays it.
class PluginRoom {
 public:
    /// On the exact clock without latency; set_controls() sets the controls. On the real-time clock
    /// the frames follow `controls`. Throws InputError.
    PluginRoom(const Scene& scene, const std::filesystem::path& hrtf, OutputFormat output,
               double sample_rate_hz, RenderClock clock, int block,
               std::shared_ptr<const ControlSnapshot> controls);

    /// On the exact clock: the values from the next sample on.
    void set_controls(const ControlValues& values) { follower_.follow(auralizer_, values); }

    /// Waits until a frame is heard, at most a few seconds. [real-time clock]
    void wait_for_frame() const;

    /// Renders at most any number of samples. [audio thread; waits on the exact clock]
    void render(const float* input, std::span<float* const> outputs, int samples);

    /// How long it is heard after its input has ended.
    std::int64_t tail_samples() const { return auralizer_.tail_samples(); }

 private:
    ControlFollower follower_;
    Auralizer auralizer_;
};

}  // namespace aula::plugin
