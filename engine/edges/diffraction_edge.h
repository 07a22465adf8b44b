#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <numbers>

#include "engine/base/tolerances.h"
#include "engine/edges/wedge_integral.h"

namespace aula {

/// An edge of the scene that diffracts sound: a straight line between the two faces of a wedge,
/// whose open angle is above pi. Angles are measured about the axis by the right-hand rule, from
/// the first face through the open space to the second.
struct DiffractionEdge {
    glm::dvec3 start{0};       ///< m, world axes
    glm::dvec3 axis{0};        ///< unit
    glm::dvec3 first_face{0};  ///< unit, in the first face, away from the edge; angle 0
    double length_m = 0;
    double open_angle_rad = 0;
    std::array<std::uint32_t, 2> triangles{};  ///< one at each face; equal at a free edge
    bool is_curved = false;                    ///< one of the edges that divide a curved surface

    glm::dvec3 point(double along_m) const { return start + along_m * axis; }

    /// The unit vector at an angle from the first face.
    glm::dvec3 direction(double angle_rad) const;

    /// A point in the coordinates of the edge, without its angle.
    WedgePoint beside(const glm::dvec3& point) const {
        const glm::dvec3 offset = point - start;
        return {glm::length(glm::cross(offset, axis)), 0, glm::dot(offset, axis)};
    }

    /// A point in the coordinates of the edge. Its angle is 0 to 2 pi.
    WedgePoint coordinates(const glm::dvec3& point) const;

    /// Likewise. A point in the plane of a screen, up to rounding, counts as on a side of it:
    /// `side` is +1 or -1, the same side for all edges of the screen.
    WedgePoint coordinates(const glm::dvec3& point, double side) const;

    /// The normal, into the open angle, of the face that is nearer to an angle.
    glm::dvec3 normal_at(double angle_rad) const {
        constexpr double kRight_rad = std::numbers::pi / 2;
        return direction(angle_rad < open_angle_rad / 2 ? kRight_rad : open_angle_rad - kRight_rad);
    }

    /// The angle of a point in the open angle, or of the face that is nearest to it.
    double open_angle_of(const glm::dvec3& point) const;
    double open_angle_of(const WedgePoint& point) const;

    /// Whether a path passes a curved surface at this edge: no neighbour is nearer to the straight
    /// line between two points, whose normal lies between those of the faces.
    bool is_nearest(const WedgePoint& source, const WedgePoint& listener) const;

    /// Whether another edge has nearly the same direction: within 26 degrees, as on a cone. A
    /// choice.
    bool is_along(const DiffractionEdge& other) const {
        return std::abs(glm::dot(axis, other.axis)) > 0.9;
    }

    /// Edges that are closer to each other are not independent. A choice: half a wavelength at
    /// 3.4 kHz.
    static constexpr double kNarrow_m = 0.05;

    /// Whether both edges bound a narrow face, such as the end of a door leaf.
    bool is_across_narrow_face(const DiffractionEdge& other) const;

    /// The angle by which the surface bends, above 0; pi at a free edge.
    float bend_rad() const { return static_cast<float>(open_angle_rad - std::numbers::pi); }

    /// Whether the edge bounds a screen without thickness: both its faces are one.
    bool is_free() const { return open_angle_rad > 2 * std::numbers::pi - tolerances::kOnFace_rad; }

    /// Whether a point at an angle lies in one of the faces.
    bool is_on_face(double angle_rad) const {
        return std::min({angle_rad, std::abs(angle_rad - open_angle_rad),
                         2 * std::numbers::pi - angle_rad}) < tolerances::kOnFace_rad;
    }

    /// Whether a point lies in the screen that a free edge bounds, or in its extension.
    bool is_in_screen(const glm::dvec3& point) const;

    // Sides on which source and listener count in the plane of a screen: the shadow of each edge.
    static constexpr double kSourceSide = 1;
    static constexpr double kListenerSide = -1;

    Wedge wedge() const { return {open_angle_rad, 0, length_m}; }
};

}  // namespace aula
