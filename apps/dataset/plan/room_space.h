#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "apps/dataset/plan/manifest.h"
#include "aula/engine/scene.h"
#include "engine/base/sampling.h"
#include "engine/rays/ray_scene.h"

namespace aula {

/// A position and orientation of a plan.
struct PlannedPose {
    Vec3 position{0};
    double yaw_deg = 0;
    double pitch_deg = 0;

    Pose pose() const;
};

/// The part of a room in which sources and receivers can be.
class RoomSpace {
 public:
    /// A box from the origin.
    explicit RoomSpace(const Vec3& size_m);
    /// The room around the listener of a scene, at time 0. `region` limits it further.
    RoomSpace(const Scene& scene, const std::optional<Bounds>& region);

    /// True for a point of the room whose distance to all surfaces is at least `clearance_m`.
    bool is_clear(const Vec3& point, float clearance_m) const;

    /// Draws poses whose `microphones`, points in the axes of a pose, are clear of the surfaces and
    /// of `others`: Placement::steps() of each, in their order. Throws InputError if there is no
    /// such position, or walk, among a thousand.
    std::vector<PlannedPose> draw_poses(const Placement& placement, std::size_t count,
                                        std::span<const Vec3> microphones,
                                        std::span<const PlannedPose> others,
                                        RandomStream& random) const;

 private:
    bool is_inside(const Vec3& point) const;
    bool is_free(const Vec3& from, const Vec3& to) const;
    bool fits(const PlannedPose& pose, const Placement& placement,
              std::span<const Vec3> microphones, std::span<const PlannedPose> others) const;

    Bounds region_;
    std::vector<std::array<Vec3, 3>> triangles_;  ///< empty: a box
    std::shared_ptr<const RayScene> rays_;        ///< null: a box
    Vec3 listener_{0};                            ///< a point of the room
};

}  // namespace aula
