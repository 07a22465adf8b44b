#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "engine/direct/edge_paths.h"
#include "engine/edges/knife_edges.h"
#include "engine/edges/scene_edges.h"
#include "engine/edges/wedge_integral.h"
#include "engine/rays/ray_scene.h"

namespace aula {

/// A path closely over parallel edges on one side of it, such as the tops of a row of screens. It
/// bends around those that block the straight path; the others lie below it. Their fields are not
/// independent: one integral over the heights of all edges replaces the sum of all paths and chains
/// over some of them.
class EdgeRow {
 public:
    /// Edges that may form rows between two points, each row ascending as `near` is.
    static std::vector<std::vector<std::uint32_t>> candidates(const SceneEdges& edges,
                                                              std::span<const std::uint32_t> near,
                                                              const glm::dvec3& source,
                                                              const glm::dvec3& listener);

    /// None if fewer than two obstacles are close to the path.
    static std::optional<EdgeRow> over(const SceneEdges& edges, std::span<const std::uint32_t> row,
                                       const glm::dvec3& source, const glm::dvec3& listener);

    /// Whether no other surface blocks the path.
    bool is_free(const SceneEdges& edges) const;

    /// Share of the row's field, 0 to 1: the paths over its edges have the rest of theirs.
    double weight() const { return weight_; }

    /// Share of a path over some edges that the row's field holds.
    double covered(std::span<const std::uint32_t> path) const;

    /// The path over the edges at which it bends. Without any it is the straight path.
    EdgePath path(const WedgeIntegral& integral, const RayScene& scene, const SceneEdges& edges,
                  const Bands& attenuation_per_m) const;

 private:
    /// An edge below or at the path.
    struct Member {
        std::uint32_t edge = 0;
        glm::dvec3 apex{0};
        double across_m = 0;  ///< coordinates in the plane across the edges, from the source
        double height_m = 0;
        double inside_m = 0;  ///< from the nearer end of the edge
        double share = 1;     ///< of an edge near the limits of a row
        bool is_bend = false;
        double along_m = 0;      ///< of the apex, on the edge
        double at_m = 0;         ///< length of the path from the source
        double turn_rad = 0;     ///< of a bend
        double clearance_m = 0;  ///< of the others
        double detour_m = 0;     ///< over them
    };

    /// Edges that faces join, as the two at the top of a box, or that are not independent.
    struct Obstacle {
        std::size_t first = 0;  ///< members
        std::size_t last = 0;
        KnifeEdge knife;
        double share = 0;
        bool is_bend = false;
    };

    /// An edge, with the middle of its open angle.
    struct OpenEdge {
        std::uint32_t edge = 0;
        glm::dvec3 axis{0};
        glm::dvec3 opens_to{0};
    };
    static std::vector<OpenEdge> open_edges(const SceneEdges& edges,
                                            std::span<const std::uint32_t> row);
    /// The members of a row along an axis.
    struct Placed {
        glm::dvec3 axis{0};
        glm::dvec3 up{0};
        std::vector<Member> members;
    };
    /// `known`: those of earlier calls for the same points and margin, and at least these edges.
    static std::optional<EdgeRow> place(const SceneEdges& edges, std::span<const OpenEdge> row,
                                        const glm::dvec3& source, const glm::dvec3& listener,
                                        double margin_m, std::vector<Placed>* known = nullptr);
    void place_members(const SceneEdges& edges, std::span<const OpenEdge> row, double margin_m);
    /// Edges farther below the path are independent: v = sqrt(4 detour / lambda) = 1 at 500 Hz.
    static constexpr double kLongestClearDetour_m = 0.16;

    void find_bends();
    void find_clearances(double along_m);
    std::vector<std::pair<std::size_t, std::size_t>> joined_by_faces(const SceneEdges& edges) const;
    void drop_covered(const SceneEdges& edges);
    void find_obstacles(const SceneEdges& edges);
    std::vector<std::uint32_t> passed_below(const SceneEdges& edges) const;
    std::vector<std::uint32_t> touched_obstacles(const SceneEdges& edges) const;
    double grazing_share() const;
    Bands levels_over_knife(const Obstacle& obstacle, const WedgeIntegral& integral,
                            const RayScene& scene, const SceneEdges& edges) const;
    double opening(const RayScene& scene, const SceneEdges& edges) const;
    ComplexBands free_field_ratio(const WedgeIntegral& integral, const RayScene& scene,
                                  const SceneEdges& edges) const;

    glm::dvec3 source_{0};
    glm::dvec3 listener_{0};
    glm::dvec3 up_{0};             ///< unit, across the edges, away from their faces
    std::vector<Member> members_;  ///< from the source to the listener
    std::vector<Obstacle> obstacles_;
    double across_m_ = 0;  ///< between the ends
    double stretch_ = 1;   ///< length of the path per length in planes across the edges
    double length_m_ = 0;
    double weight_ = 0;
};

}  // namespace aula
