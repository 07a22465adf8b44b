#include "engine/tail/zonal_moments.h"

#include <algorithm>
#include <cmath>

namespace aula {
namespace {

using Degrees = ZonalMoments::Degrees;

constexpr std::size_t kLengths = 256;  // steps of the table over the mean of x

// The maximum-entropy distribution of directions with a given mean is the von Mises-Fisher
// distribution p(u) ~ exp(k u.v). Its moments A_l, the means of the Legendre polynomials P_l(u.v),
// are ratios of Bessel functions I_(l+1/2)(k) / I_(1/2)(k) and satisfy
//     A_(l+1) = A_(l-1) - (2l + 1) / k A_l,  A_0 = 1,  A_1 = coth k - 1/k.
Degrees moments_of(double concentration) {
    Degrees moments{1};
    // The upward recurrence is stable while l < k. Otherwise the ratios
    // A_(l+1) / A_l = 1 / ((2l + 3) / k + A_(l+2) / A_(l+1)) are computed downwards (Miller).
    if (concentration > 20) {
        moments[1] = 1 / std::tanh(concentration) - 1 / concentration;
        for (std::size_t l = 1; l + 1 < moments.size(); ++l) {
            moments[l + 1] =
                moments[l - 1] - static_cast<double>(2 * l + 1) / concentration * moments[l];
        }
        return moments;
    }
    double ratio = 0;
    std::vector<double> ratios(80);
    for (std::size_t l = ratios.size(); l-- > 0;) {
        ratio = concentration / (static_cast<double>(2 * l + 3) + concentration * ratio);
        ratios[l] = ratio;
    }
    for (std::size_t l = 1; l < moments.size(); ++l) moments[l] = moments[l - 1] * ratios[l - 1];
    return moments;
}

/// The moments of the distribution whose first moment is `length`.
Degrees moments_from_first(double length) {
    if (length >= 1) {
        Degrees ones;
        ones.fill(1);
        return ones;
    }
    double low = 0;
    double high = 2 / (1 - length);
    for (int step = 0; step < 60; ++step) {
        const double middle = (low + high) / 2;
        (moments_of(middle)[1] < length ? low : high) = middle;
    }
    return moments_of((low + high) / 2);
}

/// P_l(x) of all degrees.
Degrees legendre(double x) {
    Degrees p{1, x};
    for (std::size_t l = 1; l + 1 < p.size(); ++l) {
        const auto degree = static_cast<double>(l);
        p[l + 1] = ((2 * degree + 1) * x * p[l] - degree * p[l - 1]) / (degree + 1);
    }
    return p;
}

/// The means of even degree for a density proportional to exp(k x^2).
Degrees watson_moments(double k) {
    // Of the midpoint rule: at k = 100 the density falls by e over five.
    constexpr int kPoints = 1000;
    Degrees moments{};
    for (int i = 0; i < kPoints; ++i) {
        const double x = (i + 0.5) / kPoints;
        const double weight = std::exp(k * x * x - std::max(k, 0.0));
        const Degrees p = legendre(x);
        for (std::size_t l = 0; l < p.size(); l += 2) moments[l] += weight * p[l];
    }
    const double all = moments[0];
    for (double& moment : moments) moment /= all;
    return moments;
}

/// Linear between two entries: the means of a mixture of two distributions.
Degrees between(const Degrees& from, const Degrees& to, double share) {
    Degrees mixed;
    for (std::size_t l = 0; l < mixed.size(); ++l) mixed[l] = (1 - share) * from[l] + share * to[l];
    return mixed;
}

}  // namespace

ZonalMoments::ZonalMoments() {
    constexpr int kSteps = 40;  // on either side of 0, to k = 100
    const double step = std::asinh(100.0) / kSteps;
    watson_.push_back(legendre(0));
    for (int i = -kSteps; i <= kSteps; ++i) watson_.push_back(watson_moments(std::sinh(step * i)));
    watson_.push_back(legendre(1));

    for (std::size_t n = 0; n <= kLengths; ++n) {
        const Degrees moments = moments_from_first(static_cast<double>(n) / double{kLengths});
        const Degrees even = watson(moments[2]);
        // x P_l = ((l + 1) P_(l+1) + l P_(l-1)) / (2l + 1), and x^2 = (1 + 2 P_2) / 3.
        const double c = moments[1] * 3 / (1 + 2 * moments[2]);
        Degrees rest{};
        for (std::size_t l = 3; l < rest.size(); ++l) {
            const auto degree = static_cast<double>(l);
            const double own =
                l % 2 == 0
                    ? even[l]
                    : c * ((degree + 1) * even[l + 1] + degree * even[l - 1]) / (2 * degree + 1);
            rest[l] = moments[l] - own;
        }
        directed_.push_back(rest);
    }
}

const ZonalMoments& ZonalMoments::shared() {
    static const ZonalMoments moments;
    return moments;
}

Degrees ZonalMoments::watson(double second) const {
    const auto after = std::find_if(watson_.begin() + 1, watson_.end() - 1,
                                    [&](const Degrees& entry) { return entry[2] > second; });
    const Degrees& from = *(after - 1);
    return between(from, *after,
                   std::clamp((second - from[2]) / ((*after)[2] - from[2]), 0.0, 1.0));
}

Degrees ZonalMoments::directed(double length) const {
    const double position = std::clamp(length, 0.0, 1.0) * double{kLengths};
    const std::size_t below = std::min(static_cast<std::size_t>(position), kLengths - 1);
    return between(directed_[below], directed_[below + 1], position - static_cast<double>(below));
}

}  // namespace aula
