#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>
#include <vector>

#include "engine/rays/ray_scene.h"

namespace aula {

/// The planes of a scene's triangles. Coplanar triangles of either orientation share a plane: those
/// within 0.1 degrees and 1 mm of the largest among them. A plane of a moving object moves with it
/// and keeps its index. [propagation thread]
class ScenePlanes {
 public:
    using Point = glm::dvec3;

    /// Area of the smallest plane that has image sources. An image source has the full energy of a
    /// mirror in a beam as narrow as its plane, and none beside it. The first Fresnel zone of a
    /// reflection, pi lambda d1 d2 / (d1 + d2), has 0.07 m2 at 16 kHz, with d1 and d2 of 2 m.
    static constexpr double kSmallestMirror_m2 = 0.01;

    struct Plane {
        Point normal{0};
        double offset_m = 0;          ///< dot(normal, x) on the plane
        Bounds bounds{};              ///< of its triangles
        double area_m2 = 0;           ///< of its triangles
        bool reflects = false;        ///< some part reflects specularly in some band
        std::uint32_t reference = 0;  ///< the triangle that defines the plane
        std::uint32_t object = 0;     ///< the object of all its triangles, or kManyObjects

        /// Signed distance of a point.
        double distance_m(const Point& p) const;
        Point mirror(const Point& p) const { return p - 2 * distance_m(p) * normal; }

        /// True for a plane that is too small for image sources (SpecularPaths).
        bool is_facet() const { return area_m2 < kSmallestMirror_m2; }
    };

    static constexpr std::uint32_t kNoPlane = std::numeric_limits<std::uint32_t>::max();

    explicit ScenePlanes(const RayScene& scene);

    /// Updates the planes after RayScene::move; objects move rigidly. Adds planes where an object
    /// leaves a shared plane, whose area becomes smaller.
    void scene_moved();

    /// Updates the planes after a change of the scene's materials.
    void materials_changed();

    std::size_t count() const { return planes_.size(); }
    const Plane& operator[](std::uint32_t plane) const { return planes_[plane]; }

    /// The plane of a triangle, kNoPlane if the triangle is degenerate.
    std::uint32_t of_triangle(std::uint32_t triangle) const { return plane_of_triangle_[triangle]; }

 private:
    static constexpr std::uint32_t kManyObjects = std::numeric_limits<std::uint32_t>::max();

    struct PlacedObject {
        std::uint32_t first_triangle = 0;
        std::uint32_t end_triangle = 0;
        std::array<Vec3, 3> vertices{};  ///< of its first triangle at the last update
    };

    void merge();
    void include(Plane& plane, std::uint32_t triangle) const;
    void follow(std::uint32_t object);

    const RayScene& scene_;
    std::vector<Plane> planes_;
    std::vector<std::uint32_t> plane_of_triangle_;
    std::vector<PlacedObject> objects_;
};

}  // namespace aula
