#pragma once

#include <array>

#include "engine/edges/diffraction_edge.h"
#include "engine/edges/wedge_integral.h"
#include "engine/rays/ray_scene.h"

namespace aula {

/// 0 at 0 and below, 1 at 1 and above, with a continuous derivative.
double smooth_step(double x);

/// The share of the pressure that remains over a length.
double air_loss(double length_m, const Bands& attenuation_per_m, std::size_t band);

/// Share of the pressure that a face reflects specularly.
double mirrored_pressure(const Material& material, std::size_t band);

/// How the terms of an edge's field count that belong to the reflections at its faces.
struct FaceTerms {
    double share = 1;      ///< of the terms
    bool fade_lit = true;  ///< towards the boundary of a reflection that has a separate path
};

/// The field that an edge diffracts, divided between the direct sound and the paths of the
/// reflections at its faces.
struct EdgeField {
    ComplexBands direct{};
    std::array<ComplexBands, 2> reflected{};  ///< [face]
};

/// The field that an edge diffracts. Towards the boundary of the reflection at a face, the term
/// that jumps with the reflection passes from the direct sound to its path. The terms of a face are
/// multiplied by the share of the pressure that its material reflects specularly.
EdgeField divided_edge_field(const WedgeIntegral& integral, const RayScene& scene,
                             const DiffractionEdge& edge, const WedgePoint& source,
                             const WedgePoint& listener, const FaceTerms& faces);

/// The part of that field in the direct sound. The terms of a face are multiplied by the share of
/// the pressure that its material reflects specularly.
ComplexBands edge_field(const WedgeIntegral& integral, const RayScene& scene,
                        const DiffractionEdge& edge, const WedgePoint& source,
                        const WedgePoint& listener, const FaceTerms& faces);

/// The field of a curved surface with an edge at which the path turns by an angle: that of a half
/// plane which divides the angle evenly. The angles of the points do not count.
ComplexBands curved_field(const WedgeIntegral& integral, const RayScene& scene,
                          const DiffractionEdge& edge, double turn_rad, WedgePoint source,
                          WedgePoint listener);

}  // namespace aula
