#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <vector>

#include "apps/session/frames/room_state.h"
#include "engine/scene/scene.h"

namespace aula {

bool same_pose(const Pose& a, const Pose& b);

/// What is done to one source while it plays.
struct SourceControl {
    std::optional<float> gain_db;  ///< the scene's where absent
    bool muted = false;
    bool solo = false;             ///< only sources with solo are heard if there are any
    std::optional<Vec3> position;  ///< where it was put by hand; else on its path
};

/// What is changed from frame to frame, without preparing anything anew. As it stands after
/// construction nothing is changed.
struct PlayControls {
    std::vector<SourceControl> sources;  ///< may be shorter than the scene's
    std::optional<Pose> listener;        ///< where it was put by hand; else on its path
    bool direct = true;                  ///< whether this part is heard
    bool early = true;                   ///< image sources
    bool late = true;                    ///< everything else
    std::optional<int> rays;             ///< per source and frame; the scene's where absent
    std::optional<double> frame_share;   ///< of its time that a frame may take: as many rays
    float wet = 0.5F;  ///< 0: direct sound only, 0.5: all as it is, 1: no direct sound

    SourceControl source(std::size_t s) const {
        return s < sources.size() ? sources[s] : SourceControl{};
    }

    /// Where the listener is at a time.
    Pose listener_at(const Scene& scene, double time_s) const {
        return listener ? *listener : scene.listener.pose_at(time_s);
    }

    /// Whether a source is heard, given mutes and solos.
    bool heard(std::size_t s) const;

    /// A scene with these changes at a time.
    RoomState applied_to(const Scene& scene, double time_s) const;

    /// Gains of direct sound and of the rest.
    float dry_gain() const { return direct ? std::min(1.0F, 2 * (1 - wet)) : 0; }
    float wet_gain() const { return std::min(1.0F, 2 * wet); }
};

/// `now` with all that differs between `from` and `to`: two who change controls, each by a copy of
/// its own, do not undo what the other did.
PlayControls with_changes(PlayControls now, const PlayControls& from, const PlayControls& to);

}  // namespace aula
