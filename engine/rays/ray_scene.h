#pragma once

#include <algorithm>
#include <array>
#include <compare>
#include <cstdint>
#include <glm/geometric.hpp>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "aula/engine/scene.h"
#include "engine/base/tolerances.h"
#include "engine/rays/brute_force_intersector.h"
#include "engine/rays/coplanar_faces.h"
#include "engine/rays/ray_lanes.h"

namespace aula {

class ScenePlanes;

struct Ray {
    Vec3 origin;
    Vec3 direction;  ///< unit
    float max_m = std::numeric_limits<float>::infinity();
};

/// The intersection of a ray and the scene. The triangle's index counts over all objects in order.
struct Hit {
    std::uint32_t triangle = kNoTriangle;
    float distance_m = std::numeric_limits<float>::infinity();
    float u = 0;  ///< barycentric weight of the triangle's second vertex
    float v = 0;  ///< of the third vertex

    bool any() const { return triangle != kNoTriangle; }
};

/// The scene's triangles in world coordinates at one time, and ray queries on them (Embree, robust
/// mode, both sides). Of static faces that overlap in one plane the smaller one is hit
/// (CoplanarFaces); their vertices are moved by up to 1 mm into the plane. Queries are const and
/// may run on several threads in parallel, but not in parallel with move().
class RayScene {
 public:
    struct alignas(64) Triangle {
        std::array<Vec3, 3> vertices;
        Vec3 normal;  ///< unit, by the right-hand rule; zero for a degenerate triangle
        std::uint32_t material = 0;
        std::uint32_t object = 0;

        float area_m2() const {
            return glm::length(glm::cross(vertices[1] - vertices[0], vertices[2] - vertices[0])) /
                   2;
        }
    };

    /// The triangle data that every reflection needs, stored separately to reduce memory traffic.
    struct Surface {
        Vec3 normal{0};  ///< the triangle's normal
        std::uint32_t material = 0;
    };

    /// A static triangle that has the corners of an earlier one. Rays meet only the first.
    struct Twin {
        std::uint32_t first = 0;
        std::uint32_t omitted = 0;

        friend auto operator<=>(const Twin&, const Twin&) = default;
    };

    explicit RayScene(const Scene& scene, double time_s = 0);
    ~RayScene();
    RayScene(const RayScene&) = delete;
    RayScene& operator=(const RayScene&) = delete;

    /// Moves the movable objects to the poses of their trajectories at a time. Returns the largest
    /// displacement of a vertex in metres (0: nothing changed).
    float move(double time_s);

    /// The same with one transform per object; transforms of objects that are not movable are
    /// ignored.
    float move(std::span<const RigidTransform> transforms);

    /// Assigns another material to all triangles of an object.
    void set_material(std::size_t object, const Material& material);

    /// Changes the coefficients of a material.
    void change_material(std::size_t index, const Material& material);

    /// Nearest hit of each ray beyond distance 0. Origins must be off the surfaces.
    void intersect(std::span<const Ray> rays, std::span<Hit> hits) const;

    /// The same for the first `count` lanes; those up to padded_lanes(count) receive finite values.
    void intersect(const RayLanes& rays, std::size_t count, HitLanes& hits) const;

    /// The same by Embree's query for single rays: the reference of the benchmark.
    void intersect_each(std::span<const Ray> rays, std::span<Hit> hits) const;

    /// True if no surface lies between two points. The segment is shortened at both ends, by 0.1 mm
    /// if no other length is given.
    bool visible(const Vec3& from, const Vec3& to, float shortened_m = tolerances::kOffset_m) const;

    /// A distance below which no surface lies around a point, at most `most_m`.
    float clear_m(const Vec3& point, float most_m) const;

    /// True if an opaque face lies within kBacking_m of a point of a face, in front of it or behind
    /// it, and is parallel to the face within 20 degrees. Rays that begin behind the face may miss
    /// such a face.
    bool is_backed(const Vec3& point, std::uint32_t face) const;

    /// The triangle that is heard at a point of a triangle: another one only where coplanar faces
    /// overlap.
    std::uint32_t heard_at(std::uint32_t triangle, const Vec3& point) const;

    /// Sorted.
    std::span<const Twin> twins() const { return twins_; }

    /// The static faces that overlap in one plane.
    const CoplanarFaces& coplanar_faces() const { return coplanar_faces_; }

    std::size_t triangle_count() const { return triangles_.size(); }
    const Triangle& triangle(std::uint32_t index) const { return triangles_[index]; }
    const Surface& surface(std::uint32_t triangle) const { return surfaces_[triangle]; }
    const Material& material(std::uint32_t index) const { return materials_[index]; }
    const Material& material(const Triangle& triangle) const {
        return materials_[triangle.material];
    }
    const std::vector<Triangle>& triangles() const { return triangles_; }

    /// True if a material of the scene transmits sound.
    bool transmits() const { return transmits_; }

    /// Material::transmission of a material.
    const Bands& transmission(std::uint32_t material) const { return transmissions_[material]; }

    /// True if a material transmits sound.
    bool transmits(std::uint32_t material) const { return is_transmitting_[material] != 0; }

    /// The bounds of all triangles at their present positions.
    Bounds bounds() const;

    /// True for a triangle of a movable object.
    bool moves(const Triangle& triangle) const { return objects_[triangle.object].moves(); }

    /// The hit point moved tolerances::kOffset_m along the normal to the side of the incoming ray.
    /// It is computed from the triangle's vertices, which is more exact than along the ray. The
    /// vertices are scattered in memory: avoid it in innermost loops.
    Vec3 point(const Hit& hit, const Vec3& ray_direction) const;

    /// The triangle's unit normal on the side of the incoming ray.
    Vec3 facing_normal(const Hit& hit, const Vec3& ray_direction) const;

    /// Distance within which an opaque face blocks the transmission of another one. Patches do not
    /// distinguish faces that are closer together.
    static constexpr float kBacking_m = static_cast<float>(tolerances::kApart_m);

    /// Cosine of 20 degrees, up to which two faces are parallel.
    static constexpr float kParallel = 0.9397F;

    /// The offset of a point at `distance_m` along a ray, including the rounding of long
    /// distances.
    static constexpr float offset_after(float distance_m) {
        return tolerances::kOffset_m + tolerances::kRounding * distance_m;
    }

    /// A point off the surface that a ray meets after `distance_m`: `along_m` along the ray and
    /// then `off_m` along the facing normal. The cosine of the ray's direction and that normal is
    /// -`cosine`. The point is on the ray itself, unless the ray is nearly parallel to the surface:
    /// near an acute edge a point straight above the surface may lie behind the other face.
    struct PointOff {
        float along_m = 0;
        float off_m = 0;
    };
    static constexpr PointOff point_off(float distance_m, float cosine) {
        // A choice: a point goes back along the ray by at most 1 mm.
        constexpr float kMinCosine = 0.1F;
        const float offset_m = offset_after(distance_m);
        const float back_m =
            std::min(distance_m, offset_m / (cosine > kMinCosine ? cosine : kMinCosine));
        return {distance_m - back_m, offset_m - back_m * cosine};
    }

    /// The mirror image of that point behind the surface.
    static constexpr PointOff point_beyond(float distance_m, float cosine) {
        const PointOff before = point_off(distance_m, cosine);
        return {2 * distance_m - before.along_m, -before.off_m};
    }

 private:
    void update_triangles(std::uint32_t object);
    void find_coplanar_faces(const std::vector<bool>& is_omitted);
    void hear_smaller(std::size_t count, HitLanes& hits) const;
    Hit heard(const Hit& hit) const;
    void update_few();
    void update_transmissions();
    void update_backing();
    bool has_opaque_twin(std::uint32_t triangle) const;

    struct Embree;
    std::unique_ptr<Embree> embree_;
    std::vector<Object> objects_;                    ///< vertices are kept for moving objects only
    std::vector<std::vector<Vec3>> world_vertices_;  ///< [object]
    std::vector<Triangle> triangles_;
    std::vector<Surface> surfaces_;  ///< [triangle]
    std::vector<Twin> twins_;        ///< sorted
    CoplanarFaces coplanar_faces_;
    std::vector<char> may_be_backed_;           ///< [triangle]
    std::optional<BruteForceIntersector> few_;  ///< replaces Embree where it is faster
    std::vector<Material> materials_;
    std::vector<Bands> transmissions_;   ///< [material]
    std::vector<char> is_transmitting_;  ///< [material]
    bool transmits_ = false;
    std::vector<std::optional<std::uint32_t>> own_material_;  ///< [object] by set_material
};

/// Name and version of the library that traces rays in a RayScene, as "Embree 4.3.3".
std::string ray_library();

}  // namespace aula
