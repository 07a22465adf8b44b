#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <glm/vec3.hpp>
#include <numbers>
#include <optional>
#include <span>
#include <vector>

#include "engine/edges/diffraction_edge.h"
#include "engine/edges/scene_edges.h"
#include "engine/edges/wedge_integral.h"
#include "engine/rays/ray_scene.h"

namespace aula {

/// A path from a source to a listener over several edges: the shortest over them in their order.
/// Consecutive edges of a curved surface form one bend.
class EdgeChain {
 public:
    /// None if the path would pass through the faces of its edges, or if it would bend far away
    /// from an edge that its neighbours see past.
    static std::optional<EdgeChain> over(std::span<const DiffractionEdge* const> edges,
                                         const glm::dvec3& source, const glm::dvec3& listener);

    double length_m() const { return length_m_; }

    /// Number of bends. A curved surface counts as one, and so do both edges of a narrow face: the
    /// free end of a thin door leaf is that of a screen.
    std::size_t order() const;

    /// Number of narrow faces that consecutive edges of a path bound, two edges each.
    static std::size_t narrow_faces(std::span<const DiffractionEdge* const> edges);

    /// Where the path touches the first edge after the source.
    const glm::dvec3& first_apex() const { return contacts_.front().apex; }

    /// Where the path touches the last edge before the listener.
    const glm::dvec3& last_apex() const { return contacts_.back().apex; }

    /// Where the path touches its edges, from the source to the listener.
    std::vector<Vec3> apexes() const;

    /// An estimate of the level relative to free field over the length, dB, in the band
    /// limits::kEstimated.
    double estimated_db(const WedgeIntegral& integral) const;

    /// Whether the path passes an edge so closely to the straight line between its neighbours that
    /// a ray past the edge is uncertain.
    bool is_at_boundary(std::size_t edge) const;

    /// Whether a segment at an edge leads along a screen without thickness, to another edge of it.
    bool is_beside_screen(std::size_t edge) const;

    /// Decides whether such an edge is lit: its neighbours see each other.
    void set_lit(std::size_t edge, bool is_lit);

    /// Whether no surface blocks the path.
    bool is_free(const SceneEdges& edges) const { return opening(edges) > 0; }

    /// The product of the free widths beside the edges, 0 if the path is blocked; see EdgePassage.
    double opening(const SceneEdges& edges) const;

    /// The complex pressure from a source of amplitude 1 at 1 m, the sum of both sides of a thin
    /// screen along which the path leads from edge to edge. It is the same from both ends.
    ComplexBands field(const WedgeIntegral& integral, const RayScene& scene,
                       const Bands& attenuation_per_m) const;

 private:
    /// A point where the path touches an edge.
    struct Contact {
        const DiffractionEdge* edge = nullptr;
        glm::dvec3 apex{0};
        double along_m = 0;
        double before_m = 0;  ///< length from the source
        double in_rad = 0;    ///< angles of the path's segments about the edge
        double out_rad = 0;
        bool shares_next = false;  ///< the segment to the next contact lies in a face of both

        /// Above 0: the shadow of the edge.
        double bend_rad() const { return std::abs(out_rad - in_rad) - std::numbers::pi; }
    };

    /// Contacts that diffract as one wedge: a single edge, or edges of a curved surface.
    struct Bend {
        std::size_t first = 0;  ///< contacts
        std::size_t last = 0;
        bool is_curved = false;
        double turn_rad = 0;  ///< sum over the contacts
        double middle_m = 0;  ///< length from the source to the middle of the turn
        double beyond_m = 0;  ///< detour over the bend between its neighbours
    };

    glm::dvec3 point(std::size_t index) const;  ///< 0: source, then contacts, then listener
    WedgePoint coordinates(const DiffractionEdge& edge, std::size_t index) const;
    bool find_angles();
    bool find_bends();
    void choose_face(std::size_t contact);
    bool is_along_screen(std::size_t contact) const;
    std::vector<EdgeChain> sides() const;
    void place_ends(std::size_t contact);
    ComplexBands field_of_side(const WedgeIntegral& integral, const RayScene& scene,
                               const Bands& attenuation_per_m) const;
    ComplexBands factor(const Bend& bend, double before_m, double after_m,
                        const WedgeIntegral& integral, const RayScene& scene) const;
    ComplexBands thin_screen(const WedgeIntegral& integral) const;
    std::array<double, kBandCount> shared_once(const RayScene& scene, double toward_last) const;
    double share() const;

    glm::dvec3 source_{0};
    glm::dvec3 listener_{0};
    std::vector<Contact> contacts_;
    std::vector<Bend> bends_;
    double length_m_ = 0;
};

}  // namespace aula
