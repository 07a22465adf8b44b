#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <vector>

#include "aula/engine/scene.h"

namespace aula {

bool same_pose(const Pose& a, const Pose& b);

/// The controls of one source during playback.
struct SourceControl {
    std::optional<float> gain_db;  ///< if absent: the scene's
    bool muted = false;
    bool solo = false;             ///< if any source has solo, only those with solo are audible
    std::optional<Vec3> position;  ///< set by the user; if absent: on its path
    /// Yaw, pitch and roll as in Pose, set by the user; if absent: those of its path.
    std::optional<Vec3> angles_rad;

    /// The pose of the source, given that of the scene.
    Pose over(Pose pose) const;
};

/// Settings that can change from frame to frame without new preparation. The default changes
/// nothing.
struct PlayControls {
    std::vector<SourceControl> sources;  ///< may be shorter than the scene's
    std::optional<Pose> listener;        ///< set by the user; if absent: on its path
    bool direct = true;                  ///< whether the direct sound is audible
    bool early = true;                   ///< whether image sources are audible
    bool late = true;                    ///< whether the remaining sound is audible
    std::optional<int> rays;             ///< per source and frame; if absent: the scene's
    std::optional<double> frame_share;   ///< allowed share of the frame time, which sets the rays
    float wet = 0.5F;  ///< 0: direct sound only, 0.5: unchanged, 1: no direct sound

    SourceControl source(std::size_t s) const {
        return s < sources.size() ? sources[s] : SourceControl{};
    }

    /// The listener's pose at a time.
    Pose listener_at(const Scene& scene, double time_s) const {
        return listener ? *listener : scene.listener.pose_at(time_s);
    }

    /// The pose of a source at a time; one that is attached to a listener follows the user's.
    Pose source_at(const Scene& scene, std::size_t s, double time_s) const;

    /// Whether a source is audible, according to mutes and solos.
    bool audible(std::size_t s) const;

    /// Gains of the direct sound and of the remaining sound.
    float dry_gain() const { return direct ? std::min(1.0F, 2 * (1 - wet)) : 0; }
    float wet_gain() const { return std::min(1.0F, 2 * wet); }
};

}  // namespace aula
