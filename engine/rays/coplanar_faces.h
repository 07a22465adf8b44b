#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec2.hpp>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "aula/engine/scene.h"
#include "aula/engine/vec3.h"

namespace aula {

class RayScene;
class ScenePlanes;

/// Static faces that overlap in one plane, such as a window drawn on a wall. Rays would hit either
/// by rounding; the smaller face is heard. A face is a connected region of one object and one
/// material. Faces of equal area are layers of one wall and no overlaps; nor are strips of less
/// than 2 mm in width, which rounded corners cause. Of layers at different distances, and of faces
/// beside them, rays hit those in front. In scenes with more than 250,000 overlaps, or with heaps
/// of faces that take too long to compare, planes are not searched: rays hit either face.
class CoplanarFaces {
 public:
    /// The part of a triangle on which another one is heard instead.
    struct Overlap {
        std::uint32_t covered = 0;  ///< triangle
        std::uint32_t heard = 0;    ///< triangle
        double area_m2 = 0;         ///< without parts on which a third triangle is heard
        Vec3 middle{0};             ///< a point of the overlap
        bool is_layer = false;      ///< level with each other beside a layer: neither may be moved
    };

    CoplanarFaces() = default;
    /// `is_omitted` is true for triangles that rays never meet.
    CoplanarFaces(const RayScene& scene, const ScenePlanes& planes,
                  const std::vector<bool>& is_omitted);

    /// Sorted by the covered triangle.
    std::span<const Overlap> overlaps() const { return overlaps_; }

    /// Parts of faces of equal area and different material that touch: rays hit either. `heard` is
    /// the earlier triangle.
    std::span<const Overlap> contacts() const { return contacts_; }

    /// The largest triangle of the first plane that is not searched.
    std::optional<std::uint32_t> not_searched() const { return not_searched_; }

    /// True if parts of a triangle are covered.
    bool is_covered(std::uint32_t triangle) const {
        return triangle < index_of_.size() && index_of_[triangle] != kNone;
    }

    /// Area of the parts of a triangle on which others are heard.
    double covered_m2(std::uint32_t triangle) const;

    /// Triangles that may be heard at a point of a covered triangle instead of it, in the order of
    /// precedence.
    std::span<const std::uint32_t> candidates(std::uint32_t triangle, const Vec3& point) const;

 private:
    static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

    /// The triangles on a covered one by cells of a grid along two axes of the world.
    struct Grid {
        std::array<int, 2> axes{};
        glm::vec2 low{0};
        glm::vec2 cells_per_m{0};
        int side = 1;  ///< cells along each axis
        std::vector<std::uint32_t> begin;
        std::vector<std::uint32_t> triangles;

        int cell(int axis, float at_m) const;
        std::array<std::array<int, 2>, 2> range(const Bounds& part) const;
    };

    void add(const RayScene& scene, std::span<const Overlap> on_one_triangle);

    std::vector<Overlap> overlaps_;
    std::vector<Overlap> contacts_;
    std::optional<std::uint32_t> not_searched_;
    std::vector<std::uint32_t> index_of_;  ///< [triangle] in grids_, or kNone; empty without any
    std::vector<Grid> grids_;
};

}  // namespace aula
