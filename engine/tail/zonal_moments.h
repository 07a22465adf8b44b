#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace aula {

/// Means of the Legendre polynomials P_l(x) for distributions of directions about an axis, as
/// tables. x is the cosine of the angle to the axis. Immutable. [any thread]
class ZonalMoments {
 public:
    static constexpr std::size_t kDegrees = 7;  ///< 0 to twice the order of third-order ambisonics
    using Degrees = std::array<double, kDegrees>;  ///< [degree]

    /// The first call makes the tables.
    static const ZonalMoments& shared();

    /// The means of even degree of Watson's distribution, for the mean `second` of P_2, -1/2 (all
    /// directions perpendicular to the axis) to 1.
    Degrees watson(double second) const;

    /// The means of the von Mises-Fisher distribution with the mean `length` of x, 0 to 1, less
    /// those of q(x) (1 + c x) with the same means of degree 1 and 2, where q is Watson's.
    Degrees directed(double length) const;

 private:
    ZonalMoments();

    std::vector<Degrees> watson_;    ///< by ascending degree 2
    std::vector<Degrees> directed_;  ///< [length]
};

}  // namespace aula
