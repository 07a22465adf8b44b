#include "apps/dataset/plan/room_space.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numbers>

#include "aula/exception.h"
#include "engine/rays/room_survey.h"

namespace aula {

namespace {

constexpr int kTries = 1000;
constexpr std::uint64_t kSeed = 1;
/// A receiver in a source has no defined level.
constexpr float kSmallestDistance_m = 0.01F;

/// The squared distance of a point to a triangle (Ericson, Real-Time Collision Detection, 5.1.5).
float squared_distance(const Vec3& p, const std::array<Vec3, 3>& triangle) {
    const auto& [a, b, c] = triangle;
    const Vec3 ab = b - a, ac = c - a, ap = p - a;
    const float d1 = glm::dot(ab, ap), d2 = glm::dot(ac, ap);
    const auto to = [&](const Vec3& nearest) { return glm::dot(p - nearest, p - nearest); };
    if (d1 <= 0 && d2 <= 0) return to(a);
    const Vec3 bp = p - b;
    const float d3 = glm::dot(ab, bp), d4 = glm::dot(ac, bp);
    if (d3 >= 0 && d4 <= d3) return to(b);
    const float vc = d1 * d4 - d3 * d2;
    if (vc <= 0 && d1 >= 0 && d3 <= 0) return to(a + ab * (d1 / (d1 - d3)));
    const Vec3 cp = p - c;
    const float d5 = glm::dot(ab, cp), d6 = glm::dot(ac, cp);
    if (d6 >= 0 && d5 <= d6) return to(c);
    const float vb = d5 * d2 - d1 * d6;
    if (vb <= 0 && d2 >= 0 && d6 <= 0) return to(a + ac * (d2 / (d2 - d6)));
    const float va = d3 * d6 - d5 * d4;
    if (va <= 0 && d4 >= d3 && d5 >= d6) return to(b + (c - b) * ((d4 - d3) / (d4 - d3 + d5 - d6)));
    const float sum = va + vb + vc;
    return to(a + ab * (vb / sum) + ac * (vc / sum));
}

/// True if the box of a triangle, enlarged by a distance, contains the point.
bool may_be_near(const Vec3& p, const std::array<Vec3, 3>& triangle, float distance_m) {
    const Vec3 low = glm::min(glm::min(triangle[0], triangle[1]), triangle[2]) - distance_m;
    const Vec3 high = glm::max(glm::max(triangle[0], triangle[1]), triangle[2]) + distance_m;
    return Bounds{low, high}.contains(p);
}

float rounded(double x) { return static_cast<float>(std::round(x * 1e4) / 1e4); }

float draw_between(float low, float high, RandomStream& random) {
    return rounded(std::lerp(double{low}, double{high}, double{random.uniform()}));
}

float radians(double degrees) { return static_cast<float>(degrees * std::numbers::pi / 180); }

/// The poses of a walk that begins at a pose.
std::vector<PlannedPose> walk_from(const PlannedPose& begin, const Walk& walk,
                                   RandomStream& random) {
    const double length_m = walk.length_m.draw(random);
    const double angle = 2 * std::numbers::pi * double{random.uniform()};
    std::vector<PlannedPose> poses(static_cast<std::size_t>(walk.steps), begin);
    for (std::size_t i = 0; i < poses.size(); ++i) {
        const double m = length_m * static_cast<double>(i) / (walk.steps - 1);
        Vec3& position = poses[i].position;
        position.x = rounded(double{begin.position.x} + m * std::cos(angle));
        position.y = rounded(double{begin.position.y} + m * std::sin(angle));
    }
    return poses;
}

}  // namespace

Pose PlannedPose::pose() const {
    return {.position = position, .yaw_rad = radians(yaw_deg), .pitch_rad = radians(pitch_deg)};
}

RoomSpace::RoomSpace(const Vec3& size_m) : region_{Vec3(0), size_m} {}

RoomSpace::RoomSpace(const Scene& scene, const std::optional<Bounds>& region)
    : region_(region ? *region : geometry_bounds(scene.objects)),
      rays_(std::make_shared<const RayScene>(scene)),
      listener_(scene.listener.pose_at(0).position) {
    if (scene.objects.empty()) throw InputError("the scene has no geometry; expected a room");
    for (std::uint32_t t = 0; t < rays_->triangle_count(); ++t)
        triangles_.push_back(rays_->triangle(t).vertices);
}

bool RoomSpace::is_inside(const Vec3& point) const {
    if (!rays_) return true;
    const std::array<Vec3, 2> points{point, listener_};
    return outside_room(*rays_, points, kSeed)[0] == 0 &&
           connected(*rays_, std::span(points).last(1), std::span(points).first(1), kSeed)[0] != 0;
}

bool RoomSpace::is_clear(const Vec3& point, float clearance_m) const {
    const Vec3 least = glm::min(point - region_.min, region_.max - point);
    const float box_m = rays_ ? 0 : clearance_m;
    if (std::min({least.x, least.y, least.z}) < box_m) return false;
    for (const auto& triangle : triangles_)
        if (may_be_near(point, triangle, clearance_m) &&
            squared_distance(point, triangle) < clearance_m * clearance_m)
            return false;
    return is_inside(point);
}

bool RoomSpace::fits(const PlannedPose& pose, const Placement& placement,
                     std::span<const Vec3> microphones, std::span<const PlannedPose> others) const {
    const glm::mat3 axes = pose.pose().rotation();
    const float apart_m = std::max(placement.source_clearance_m, kSmallestDistance_m);
    return std::all_of(microphones.begin(), microphones.end(), [&](const Vec3& microphone) {
        const Vec3 point = pose.position + axes * microphone;
        return std::all_of(others.begin(), others.end(),
                           [&](const PlannedPose& other) {
                               return glm::distance(point, other.position) >= apart_m;
                           }) &&
               is_clear(point, placement.wall_clearance_m);
    });
}

/// True if no surface lies between two points of the room.
bool RoomSpace::is_free(const Vec3& from, const Vec3& to) const {
    return !rays_ || rays_->visible(from, to);
}

std::vector<PlannedPose> RoomSpace::draw_poses(const Placement& placement, std::size_t count,
                                               std::span<const Vec3> microphones,
                                               std::span<const PlannedPose> others,
                                               RandomStream& random) const {
    const float margin_m = rays_ ? 0 : placement.wall_clearance_m;
    const Vec3 low = region_.min + margin_m;
    const Vec3 high = region_.max - margin_m;
    std::vector<PlannedPose> poses;
    count *= static_cast<std::size_t>(placement.steps());
    for (int tries = 0; poses.size() < count; ++tries) {
        const bool possible = low.x <= high.x && low.y <= high.y && low.z <= high.z;
        if (!possible || tries == kTries)
            throw InputError(placement.walk ? "no walk has these clearances"
                                            : "no position has these clearances");
        PlannedPose pose;
        pose.position = {draw_between(low.x, high.x, random), draw_between(low.y, high.y, random),
                         placement.z_m ? static_cast<float>(placement.z_m->draw(random))
                                       : draw_between(low.z, high.z, random)};
        pose.yaw_deg = placement.yaw_deg.draw(random);
        pose.pitch_deg = placement.pitch_deg.draw(random);
        const std::vector<PlannedPose> steps =
            placement.walk ? walk_from(pose, *placement.walk, random) : std::vector{pose};
        const auto is_clear_step = [&](const PlannedPose& step) {
            return fits(step, placement, microphones, others) &&
                   is_free(pose.position, step.position);
        };
        if (!std::all_of(steps.begin(), steps.end(), is_clear_step)) continue;
        poses.insert(poses.end(), steps.begin(), steps.end());
        tries = 0;
    }
    return poses;
}

}  // namespace aula
