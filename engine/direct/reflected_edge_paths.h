#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "aula/engine/bands.h"
#include "engine/direct/edge_paths.h"
#include "engine/edges/scene_edges.h"
#include "engine/edges/wedge_integral.h"
#include "engine/rays/oriented_directivity.h"
#include "engine/rays/ray_scene.h"
#include "engine/rays/scene_planes.h"

namespace aula {

/// A path over one edge that is reflected at a plane before the edge, after it, or both.
struct ReflectedEdgePath {
    std::uint32_t plane = 0;
    EdgePath path{};

    /// Where the reflection without the edge passes it so closely that a ray is uncertain: whether
    /// the edge leaves that reflection free.
    std::optional<bool> is_image_audible{};
    std::uint32_t triangle = 0;  ///< of the plane, at the reflection point
};

/// Finds paths over one edge with reflections at large planes near a source and a listener, such as
/// those over a screen that the floor reflects in front of it and behind it. The field is that of
/// the edge between the images of source and listener in the plane. [several threads]
class ReflectedEdgePaths {
 public:
    ReflectedEdgePaths(const RayScene& scene, const SceneEdges& edges, double speed_of_sound_m_s);

    /// The strongest kMax paths over the edges in memory.reflections.bent. Weak ones compared with
    /// `total`, the energy of all other paths, fade out, and so do those whose reflection point
    /// comes near a free edge of the plane. `has_moved`: an object has moved. `is_twice`: a path
    /// may be reflected before and after the edge.
    std::vector<ReflectedEdgePath> find(const glm::dvec3& source, const glm::dvec3& listener,
                                        const ScenePlanes& planes, bool is_twice,
                                        const OrientedDirectivity& directivity,
                                        const Bands& attenuation_per_m, const Bands& total,
                                        bool has_moved, PairMemory& memory) const;

    /// Of a pair. A choice, like EdgePaths::kMaxTaps.
    static constexpr std::size_t kMax = 8;

    /// Of a pair, the nearest: those of a box.
    static constexpr std::size_t kMaxPlanes = 6;

 private:
    struct Candidate;
    using Outlines = std::vector<std::pair<std::uint32_t, std::uint32_t>>;  ///< plane, edge
    void select_planes(const glm::dvec3& source, const glm::dvec3& listener,
                       const ScenePlanes& planes, bool has_moved, PairReflections& memory) const;
    std::vector<Candidate> candidates(const glm::dvec3& source, const glm::dvec3& listener,
                                      const ScenePlanes& planes, bool is_twice,
                                      const PairReflections& memory) const;
    std::optional<std::uint32_t> reflect(const glm::dvec3& end, const Vec3& beside_edge,
                                         const ScenePlanes& planes, std::uint32_t plane,
                                         const glm::dvec3& reflection_point) const;
    Outlines outlines_of(const ScenePlanes& planes, const PairMemory& memory) const;
    std::array<double, kBandCount> coverage(const Candidate& candidate, const glm::dvec3& end,
                                            const glm::dvec3& reflection_point,
                                            const Outlines& outlines) const;

    const RayScene& scene_;
    const SceneEdges& edges_;
    WedgeIntegral integral_;
};

}  // namespace aula
