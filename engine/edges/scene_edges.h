#pragma once

#include <cstdint>
#include <glm/mat3x3.hpp>
#include <vector>

#include "engine/edges/diffraction_edge.h"
#include "engine/rays/ray_scene.h"

namespace aula {

/// Whether two boxes have a point in common, one of them enlarged by a margin.
bool overlap(const Bounds& a, const Bounds& b, float margin_m = 0);

/// The diffracting edges of a scene. All objects that do not move form one soup of triangles, in
/// which walls of different objects close each other's edges. Each movable object has separate
/// edges, which move with it and keep their indices. Objects below 0.3 m are shorter than a
/// wavelength up to 1 kHz: they have no edges, and paths pass through them. [propagation thread]
class SceneEdges {
 public:
    explicit SceneEdges(const RayScene& scene);

    /// Updates the edges after RayScene::move; objects move rigidly.
    void scene_moved();

    /// RayScene::visible without the small objects.
    bool visible(const Vec3& from, const Vec3& to) const;

    /// Likewise between two points at a face with this normal: if bends below those of edges hide
    /// them from each other, above the face.
    bool visible_along_face(const Vec3& from, const Vec3& to, const Vec3& normal) const;

    const RayScene& scene() const { return scene_; }

    /// Whether a fixed edge coincides at a point of it with that of an object which moves, as a
    /// jamb with the leaf that is hung in it: the edge that moves counts.
    bool is_covered(std::uint32_t edge, const glm::dvec3& point) const;

    /// Whether there are small objects.
    bool has_small() const { return has_small_; }

    /// Diagonal of the smallest object with edges. A choice: a wavelength at 1.1 kHz.
    static constexpr float kSmall_m = 0.3F;

    std::size_t count() const { return edges_.size(); }
    const DiffractionEdge& operator[](std::uint32_t edge) const { return edges_[edge]; }
    const std::vector<DiffractionEdge>& all() const { return edges_; }

 private:
    /// A movable object and its edges. Its largest triangle defines its axes.
    struct MovingEdges {
        std::uint32_t reference = 0;  ///< triangle
        std::uint32_t first_edge = 0;
        std::uint32_t end_edge = 0;
        std::vector<DiffractionEdge> local;  ///< in the axes of the triangle
        Bounds bounds;                       ///< of its edges
    };

    /// Origin and axes of a triangle.
    struct Frame {
        glm::dvec3 origin{0};
        glm::dmat3 axes{1};  ///< orthonormal
    };

    void find_small();
    bool is_small(std::uint32_t triangle) const {
        return is_small_[scene_.triangle(triangle).object] != 0;
    }
    template <typename Passes>
    bool visible_past(const Vec3& from, const Vec3& to, const Passes& passes) const;
    bool is_buried(const DiffractionEdge& edge) const;
    void follow(MovingEdges& object);
    Frame frame_of(std::uint32_t triangle) const;

    const RayScene& scene_;
    std::vector<char> is_small_;  ///< [object]
    bool has_small_ = false;
    std::vector<DiffractionEdge> edges_;
    std::vector<MovingEdges> moving_;
};

}  // namespace aula
