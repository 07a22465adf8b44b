#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <glm/geometric.hpp>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "engine/rays/brute_force_intersector.h"
#include "engine/rays/ray_lanes.h"
#include "engine/scene/scene.h"

namespace aula {

struct Ray {
    Vec3 origin;
    Vec3 direction;  ///< unit
    float max_m = std::numeric_limits<float>::infinity();
};

/// Where a ray met the scene. The triangle is a global index over all objects in order.
struct Hit {
    std::uint32_t triangle = kNoTriangle;
    float distance_m = std::numeric_limits<float>::infinity();
    float u = 0;  ///< barycentric weight of the triangle's second vertex
    float v = 0;  ///< of its third vertex

    bool any() const { return triangle != kNoTriangle; }
};

/// The scene's triangles in world coordinates at one time, and rays against them (Embree, robust
/// mode, both sides). Queries are const and may run on several threads; move() may not run beside
/// them.
class RayScene {
 public:
    struct alignas(64) Triangle {
        std::array<Vec3, 3> vertices;
        Vec3 normal;  ///< unit, by the right hand rule; zero for a degenerate triangle
        std::uint32_t material = 0;
        std::uint32_t object = 0;

        float area_m2() const {
            return glm::length(glm::cross(vertices[1] - vertices[0], vertices[2] - vertices[0])) /
                   2;
        }
    };

    /// What of a triangle every reflection asks for, apart: far less memory is passed through.
    struct Surface {
        Vec3 normal{0};  ///< as the triangle's
        std::uint32_t material = 0;
    };

    explicit RayScene(const Scene& scene, double time_s = 0);
    ~RayScene();
    RayScene(const RayScene&) = delete;
    RayScene& operator=(const RayScene&) = delete;

    /// Takes the moving objects to where their paths are at a time. Returns the largest distance
    /// in metres that a vertex moved (0: nothing changed).
    float move(double time_s);

    /// The same by a transform for each object; those of objects that do not move are ignored.
    float move(std::span<const RigidTransform> transforms);

    /// Gives all triangles of an object another material.
    void set_material(std::size_t object, const Material& material);

    /// Gives a material other coefficients.
    void change_material(std::size_t index, const Material& material);

    /// Nearest hit of each ray beyond distance 0 (give origins that are off the surface).
    void intersect(std::span<const Ray> rays, std::span<Hit> hits) const;

    /// The same for the first `count` lanes; those up to padded_lanes(count) get finite numbers.
    void intersect(const RayLanes& rays, std::size_t count, HitLanes& hits) const;

    /// The same by Embree's plain query for one ray at a time: what the benchmark measures the
    /// engine against.
    void intersect_each(std::span<const Ray> rays, std::span<Hit> hits) const;

    /// True if nothing lies between two points; both ends are shortened by 0.1 mm.
    bool visible(const Vec3& from, const Vec3& to) const;

    std::size_t triangle_count() const { return triangles_.size(); }
    const Triangle& triangle(std::uint32_t index) const { return triangles_[index]; }
    const Surface& surface(std::uint32_t triangle) const { return surfaces_[triangle]; }
    const Material& material(std::uint32_t index) const { return materials_[index]; }
    const Material& material(const Triangle& triangle) const {
        return materials_[triangle.material];
    }
    const std::vector<Triangle>& triangles() const { return triangles_; }

    /// True for a triangle of a movable object.
    bool moves(const Triangle& triangle) const { return objects_[triangle.object].moves(); }

    /// The hit point from the triangle's own vertices (more exact than along the ray, but each lies
    /// elsewhere in memory: not for the innermost loops), moved kOffset_m along the normal to the
    /// side that the ray came from.
    Vec3 point(const Hit& hit, const Vec3& ray_direction) const;

    /// The triangle's unit normal on the side that the ray came from.
    Vec3 facing_normal(const Hit& hit, const Vec3& ray_direction) const;

    /// Every point on a surface is used at this distance from it, on its own side: the starts of
    /// rays, the patch that a deposit, a gather ray or an area sample falls in.
    static constexpr float kOffset_m = 1e-4F;

    /// The same for a point that is found along a ray, where a long way is rounded.
    static constexpr float offset_after(float way_m) { return kOffset_m + 4e-7F * way_m; }

    /// A point off the surface that a ray meets after `distance_m`: `along_m` along the ray and
    /// then `off_m` along the facing normal, of which the ray's direction has the cosine -`cosine`.
    /// It is on the ray itself, but where the ray is nearly parallel to the surface: beside an
    /// acute edge a point straight above the surface may lie behind the other face.
    struct PointOff {
        float along_m = 0;
        float off_m = 0;
    };
    static constexpr PointOff point_off(float distance_m, float cosine) {
        constexpr float kLeastCosine = 0.1F;
        const float offset_m = offset_after(distance_m);
        const float back_m =
            std::min(distance_m, offset_m / (cosine > kLeastCosine ? cosine : kLeastCosine));
        return {distance_m - back_m, offset_m - back_m * cosine};
    }

 private:
    void update_triangles(std::uint32_t object);
    void update_few();

    struct Embree;
    std::unique_ptr<Embree> embree_;
    std::vector<Object> objects_;  ///< vertices kept of the moving ones only
    std::vector<Triangle> triangles_;
    std::vector<Surface> surfaces_;             ///< [triangle]
    std::optional<BruteForceIntersector> few_;  ///< in place of Embree where that is faster
    std::vector<Material> materials_;
    std::vector<std::optional<std::uint32_t>> own_material_;  ///< [object] by set_material
};

}  // namespace aula
