#include "aula/engine/scene.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vector_relational.hpp>
#include <iterator>
#include <numbers>
#include <utility>

#include "aula/engine/material_library.h"
#include "aula/exception.h"
#include "engine/input/names.h"

namespace aula {
namespace {

Pose interpolate(const Pose& a, const Pose& b, float weight) {
    const auto mix = [weight](const auto& x, const auto& y) { return x + weight * (y - x); };
    return {mix(a.position, b.position), mix(a.yaw_rad, b.yaw_rad), mix(a.pitch_rad, b.pitch_rad),
            mix(a.roll_rad, b.roll_rad)};
}

/// The path of a place on the listener. The arcs of its turns become chords of at most 5 degrees,
/// which are within 0.1 % of the place's distance from the listener for turns about one axis, 0.5 %
/// about three. Of more than kMostChords turns, which is an hour at 4 turns a second, the last ones
/// are straight lines.
Trajectory attached_path(const Trajectory& listener, const Vec3& from_listener) {
    constexpr float kTurn_rad = 5 * std::numbers::pi_v<float> / 180;
    constexpr float kMostOfTurn = 1000;
    constexpr int kMostChords = 1'000'000;
    int left = kMostChords;
    Trajectory path{{}, listener.loop};
    const Trajectory::Keyframe* before = nullptr;
    for (const Trajectory::Keyframe& point : listener.points) {
        if (before != nullptr && point.time_s > before->time_s) {
            const float turn_rad =
                std::max({std::abs(point.pose.yaw_rad - before->pose.yaw_rad),
                          std::abs(point.pose.pitch_rad - before->pose.pitch_rad),
                          std::abs(point.pose.roll_rad - before->pose.roll_rad)});
            const int chords = std::min(
                static_cast<int>(std::min(std::ceil(turn_rad / kTurn_rad), kMostOfTurn)), left + 1);
            left -= std::max(chords - 1, 0);
            for (int i = 1; i < chords; ++i) {
                const double share = static_cast<double>(i) / chords;
                path.points.push_back(
                    {std::lerp(before->time_s, point.time_s, share),
                     interpolate(before->pose, point.pose, static_cast<float>(share))
                         .at(from_listener)});
            }
        }
        path.points.push_back({point.time_s, point.pose.at(from_listener)});
        before = &point;
    }
    return path;
}

/// tau = 10^(-R/10)
double transmitted_share(float sound_reduction_db) {
    return std::pow(10, -double{sound_reduction_db} / 10);
}

}  // namespace

// Yaw rotates x towards y, pitch x towards z, roll y towards z; roll is applied first. The columns
// are the local axes in world coordinates.
glm::mat3 Pose::rotation() const {
    const auto cosine = [](float x) { return static_cast<float>(std::cos(double{x})); };
    const auto sine = [](float x) { return static_cast<float>(std::sin(double{x})); };
    const float cy = cosine(yaw_rad), sy = sine(yaw_rad);
    const float cp = cosine(pitch_rad), sp = sine(pitch_rad);
    const float cr = cosine(roll_rad), sr = sine(roll_rad);
    const glm::mat3 yaw{Vec3{cy, sy, 0}, Vec3{-sy, cy, 0}, Vec3{0, 0, 1}};
    const glm::mat3 pitch{Vec3{cp, 0, sp}, Vec3{0, 1, 0}, Vec3{-sp, 0, cp}};
    const glm::mat3 roll{Vec3{1, 0, 0}, Vec3{0, cr, sr}, Vec3{0, -sr, cr}};
    return yaw * pitch * roll;
}

Pose Pose::at(const Vec3& local_position) const {
    return {position + rotation() * local_position, yaw_rad, pitch_rad, roll_rad};
}

Pose Trajectory::at(double time_s) const {
    assert(!points.empty());
    if (loop && duration_s() > 0) {
        time_s = std::fmod(time_s, duration_s());
        if (time_s < 0) time_s += duration_s();
    }
    const auto next =
        std::upper_bound(points.begin(), points.end(), time_s,
                         [](double time, const Keyframe& point) { return time < point.time_s; });
    if (next == points.begin()) return points.front().pose;
    if (next == points.end()) return points.back().pose;
    const Keyframe& previous = *std::prev(next);
    const double weight = (time_s - previous.time_s) / (next->time_s - previous.time_s);
    return interpolate(previous.pose, next->pose, static_cast<float>(weight));
}

Bands Material::transmission() const {
    Bands share;
    if (!sound_reduction_db) return share;
    for (std::size_t b = 0; b < kBandCount; ++b) {
        share[b] = std::min(static_cast<float>(transmitted_share((*sound_reduction_db)[b])),
                            absorption[b]);
    }
    return share;
}

bool Material::transmits_too_much(std::size_t band) const {
    constexpr double kRounding = 1e-6;  // of single precision
    return transmitted_share((*sound_reduction_db)[band]) >
           double{absorption[band]} * (1 + kRounding);
}

std::vector<Vec3> Object::world_vertices(const RigidTransform& transform) const {
    const Vec3 offset = transform.translation + translation;
    std::vector<Vec3> world = vertices;
    for (Vec3& v : world) v = (moves() ? transform.rotation * v : v) + offset;
    return world;
}

void Bounds::add(const Vec3& point) {
    min = glm::min(min, point);
    max = glm::max(max, point);
}

void Bounds::add(std::span<const Vec3> points) {
    for (const Vec3& point : points) add(point);
}

float Bounds::diagonal_m() const { return glm::distance(min, max); }

bool Bounds::contains(const Vec3& point) const {
    return glm::all(glm::lessThanEqual(min, point)) && glm::all(glm::lessThanEqual(point, max));
}

Bounds geometry_bounds(const std::vector<Object>& objects) {
    Bounds bounds;
    for (const Object& object : objects) {
        bounds.add(object.world_vertices(0));
        if (!object.path) continue;
        // A path may have as many keyframes as a mesh has vertices, so only the object's box is
        // transformed.
        Bounds local;
        local.add(object.vertices);
        Object box;
        box.translation = object.translation;
        box.path = object.path;
        for (const float x : {local.min.x, local.max.x}) {
            for (const float y : {local.min.y, local.max.y}) {
                for (const float z : {local.min.z, local.max.z}) box.vertices.emplace_back(x, y, z);
            }
        }
        for (const Trajectory::Keyframe& point : object.path->points) {
            bounds.add(box.world_vertices(point.time_s));
        }
    }
    return bounds;
}

void Scene::attach_sources() {
    for (Source& source : sources) {
        if (!source.from_listener) continue;
        source.set_pose(listener.pose_at(0).at(*source.from_listener));
        source.path.reset();
        if (listener.path) source.path = attached_path(*listener.path, *source.from_listener);
    }
}

Material Scene::find_material(const std::string& name) const {
    for (const Material& material : materials)
        if (material.name == name) return material;
    for (const LibraryMaterial& known : material_library())
        if (known.material.name == name) return known.material;
    throw InputError("there is no material " + quoted(name) +
                     "; expected one of the scene or of the library");
}

std::size_t Scene::add_object(std::vector<Vec3> vertices,
                              std::vector<std::array<std::uint32_t, 3>> triangles,
                              const std::string& material, std::string name) {
    const Material wanted = find_material(material);
    const auto found = std::find_if(materials.begin(), materials.end(), [&](const Material& known) {
        return known.name == wanted.name;
    });
    const auto index = static_cast<std::uint32_t>(found - materials.begin());
    if (found == materials.end()) materials.push_back(wanted);
    Object object;
    object.name = std::move(name);
    object.triangle_materials.assign(triangles.size(), index);
    object.vertices = std::move(vertices);
    object.triangles = std::move(triangles);
    objects.push_back(std::move(object));
    return objects.size() - 1;
}

}  // namespace aula
