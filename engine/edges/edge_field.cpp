#include "engine/edges/edge_field.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>

namespace aula {

double mirrored_pressure(const Material& material, std::size_t band) {
    return std::sqrt(double{1 - material.absorption[band]} * double{1 - material.scattering[band]});
}

double smooth_step(double x) {
    x = std::clamp(x, 0.0, 1.0);
    return x * x * (3 - 2 * x);
}

double air_loss(double length_m, const Bands& attenuation_per_m, std::size_t band) {
    return std::exp(-0.5 * double{attenuation_per_m[band]} * length_m);
}

/// The reflections at the faces are not part of the direct sound. The terms that jump with them
/// therefore pass to the paths of the reflections towards their boundaries in the lit zone, where
/// L0 - (length of the reflection) is below lambda / 16. In the shadow all terms count, and so do
/// they at grazing incidence; from there to the boundary of a reflection their weight decreases to
/// 0, however near it is.
EdgeField divided_edge_field(const WedgeIntegral& integral, const RayScene& scene,
                             const DiffractionEdge& edge, const WedgePoint& source,
                             const WedgePoint& listener, const FaceTerms& faces) {
    const WedgeField terms = integral.field(edge.wedge(), source, listener);
    const double rs = source.radius_m;
    const double rl = listener.radius_m;
    const double dz = source.along_m - listener.along_m;
    const double apex_length_m = std::hypot(rs + rl, dz);
    const auto beyond_m = [&](double angle_rad) {
        return apex_length_m -
               std::sqrt(
                   std::max(0.0, rs * rs + rl * rl - 2 * rs * rl * std::cos(angle_rad) + dz * dz));
    };
    const double sum_rad = source.angle_rad + listener.angle_rad;
    const std::array<double, 2> reflection_m{beyond_m(sum_rad),
                                             beyond_m(2 * edge.open_angle_rad - sum_rad)};
    const double direct_m = beyond_m(source.angle_rad - listener.angle_rad);
    const bool fade = faces.fade_lit && WedgeIntegral::is_lit(source, listener);
    std::array<double, 2> near_shadow{1, 1};
    for (std::size_t face = 0; face < 2 && fade; ++face) {
        if (direct_m > 0) near_shadow[face] = smooth_step(reflection_m[face] / direct_m);
    }
    EdgeField field;
    for (std::size_t b = 0; b < kBandCount; ++b) {
        const double per_m = 8 * integral.wave_number_per_m(b) / std::numbers::pi;  // 16 / lambda
        field.direct[b] = terms.incident[b];
        for (std::size_t face = 0; face < 2; ++face) {
            const double weight =
                std::max(near_shadow[face], smooth_step(reflection_m[face] * per_m));
            const Material& material = scene.material(scene.triangle(edge.triangles[face]));
            const std::complex<double> term =
                mirrored_pressure(material, b) *
                (face == 0 ? terms.first_face[b] : terms.second_face[b]);
            field.direct[b] += faces.share * weight * term;
            if (fade) field.reflected[face][b] = faces.share * (1 - weight) * term;
        }
    }
    return field;
}

ComplexBands edge_field(const WedgeIntegral& integral, const RayScene& scene,
                        const DiffractionEdge& edge, const WedgePoint& source,
                        const WedgePoint& listener, const FaceTerms& faces) {
    return divided_edge_field(integral, scene, edge, source, listener, faces).direct;
}

/// Compared with the series of a rigid column, the wedge between the tangent planes at the first
/// and last contact is up to 9 dB too loud: its faces mirror both the source and the listener. A
/// curved surface bends away from them.
ComplexBands curved_field(const WedgeIntegral& integral, const RayScene& scene,
                          const DiffractionEdge& edge, double turn_rad, WedgePoint source,
                          WedgePoint listener) {
    DiffractionEdge screen = edge;
    screen.open_angle_rad = 2 * std::numbers::pi;
    source.angle_rad = (std::numbers::pi - turn_rad) / 2;
    listener.angle_rad = source.angle_rad + std::numbers::pi + turn_rad;
    return edge_field(integral, scene, screen, source, listener, {.fade_lit = false});
}

}  // namespace aula
