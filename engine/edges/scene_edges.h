#pragma once

#include <cstdint>
#include <glm/mat3x3.hpp>
#include <vector>

#include "engine/edges/diffraction_edge.h"
#include "engine/rays/ray_scene.h"

namespace aula {

/// The diffracting edges of a scene. All objects that do not move form one soup of triangles, in
/// which walls of different objects close each other's edges. Each movable object has separate
/// edges, which move with it and keep their indices. [propagation thread]
class SceneEdges {
 public:
    explicit SceneEdges(const RayScene& scene);

    /// Updates the edges after RayScene::move; objects move rigidly.
    void scene_moved();

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
    };

    /// Origin and axes of a triangle.
    struct Frame {
        glm::dvec3 origin{0};
        glm::dmat3 axes{1};  ///< orthonormal
    };

    bool is_buried(const DiffractionEdge& edge) const;
    void follow(const MovingEdges& object);
    Frame frame_of(std::uint32_t triangle) const;

    const RayScene& scene_;
    std::vector<DiffractionEdge> edges_;
    std::vector<MovingEdges> moving_;
};

}  // namespace aula
