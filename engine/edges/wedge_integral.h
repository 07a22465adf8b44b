#pragma once

#include <array>
#include <complex>
#include <limits>
#include <numbers>
#include <vector>

#include "aula/engine/bands.h"

namespace aula {

/// Complex amplitudes at the centres of the octave bands, 1000 Hz x 2^n.
using ComplexBands = std::array<std::complex<double>, kBandCount>;

/// Two rigid half planes that meet in an edge, the z axis. Sound propagates in the open angle
/// between them: 2 pi for a half plane, 3 pi / 2 for the outer corner of a wall.
struct Wedge {
    double open_angle_rad = 2 * std::numbers::pi;             ///< above pi, up to 2 pi
    double low_m = -std::numeric_limits<double>::infinity();  ///< ends of the edge along z
    double high_m = std::numeric_limits<double>::infinity();
};

/// A point in cylindrical coordinates of an edge.
struct WedgePoint {
    double radius_m = 0;   ///< distance from the line of the edge
    double angle_rad = 0;  ///< from the first face, 0 to the open angle
    double along_m = 0;    ///< coordinate along the edge
};

/// The point of the line of an edge on the shortest path between two points over it, of which at
/// most one is on the line.
double apex_m(const WedgePoint& a, const WedgePoint& b);

/// The length between two points over a point of the line of an edge.
double length_over_m(const WedgePoint& a, const WedgePoint& b, double along_m);

/// The field that an edge diffracts from a source of amplitude 1 at 1 m, in the terms that the
/// boundaries of geometrical acoustics divide. Each term jumps where its geometrical part appears,
/// so that their sum is continuous. Time factor exp(+i omega t).
struct WedgeField {
    ComplexBands incident{};     ///< jumps with the direct sound
    ComplexBands first_face{};   ///< jumps with the reflection at the first face
    ComplexBands second_face{};  ///< jumps with the reflection at the second face

    ComplexBands total() const;
};

/// The exact diffraction of a finite wedge with rigid faces at the centres of all octave bands:
/// Biot and Tolstoy's field as a line integral along the edge (Svensson et al. 1999), evaluated on
/// its path of steepest descent. [several threads]
class WedgeIntegral {
 public:
    explicit WedgeIntegral(double speed_of_sound_m_s);

    /// The diffracted field. Source and receiver lie in the open angle. A radius below
    /// kLeastRadius_m counts as that. On a boundary of geometrical acoustics the point counts as in
    /// the shadow.
    WedgeField field(const Wedge& wedge, WedgePoint source, WedgePoint receiver) const;

    /// Whether the faces of a wedge leave the straight line between two points free.
    static bool is_lit(const WedgePoint& source, const WedgePoint& receiver);

    double wave_number_per_m(std::size_t band) const {
        return lowest_wave_number_per_m_ * static_cast<double>(1U << band);
    }

    /// A choice, below the radius of a head (8.75 cm): an ear that is nearer to an edge is no
    /// point.
    static constexpr double kLeastRadius_m = 0.05;

 private:
    struct Terms;
    void add_end(const Terms& terms, double beyond_apex_m, double factor, WedgeField& sum) const;

    double lowest_wave_number_per_m_;
    static constexpr std::size_t kNodes = 44;
    std::array<double, kNodes + kBandCount> decay_{};  ///< exp(-k q) at node j for band b: [j + b]
};

}  // namespace aula
