#include "engine/tail/directional_covariance.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "engine/base/spherical_harmonics.h"

namespace aula {
namespace {

constexpr int kHighestOrder = 3;
constexpr std::size_t kMaxChannels = (kHighestOrder + 1) * (kHighestOrder + 1);
/// Harmonics up to twice the order.
constexpr std::size_t kMaxHarmonics = (2 * kHighestOrder + 1) * (2 * kHighestOrder + 1);
constexpr std::size_t kLengths = 256;  // steps of the table over |mean|

int order_of(std::size_t channel) {
    return static_cast<int>(std::sqrt(static_cast<double>(channel) + 0.5));
}

/// Quadrature over the sphere with weights of sum 1, exact for polynomials of degree below
/// 2 `rings`: Gauss-Legendre in z, uniform in azimuth.
struct Quadrature {
    std::vector<Vec3> directions;
    std::vector<double> weights;

    explicit Quadrature(int rings) {
        const int around = 2 * rings;
        for (int i = 0; i < rings; ++i) {
            double z = std::cos(std::numbers::pi * (i + 0.75) / (rings + 0.5));
            double slope = 1;
            for (int step = 0; step < 20; ++step) {
                double before = 1;
                double p = z;
                for (int l = 1; l < rings; ++l) {
                    const double next = ((2 * l + 1) * z * p - l * before) / (l + 1);
                    before = p;
                    p = next;
                }
                slope = rings * (z * p - before) / (z * z - 1);
                z -= p / slope;
            }
            const double weight = 1 / ((1 - z * z) * slope * slope);
            for (int k = 0; k < around; ++k) {
                const double azimuth = 2 * std::numbers::pi * k / around;
                const double r = std::sqrt(1 - z * z);
                directions.emplace_back(r * std::cos(azimuth), r * std::sin(azimuth), z);
                weights.push_back(weight / around);
            }
        }
    }
};

// The maximum-entropy distribution of directions with a given mean is the von Mises-Fisher
// distribution p(u) ~ exp(k u.v). Its moments A_l, the means of the Legendre polynomials P_l(u.v),
// are ratios of Bessel functions I_(l+1/2)(k) / I_(1/2)(k) and satisfy
//     A_(l+1) = A_(l-1) - (2l + 1) / k A_l,  A_0 = 1,  A_1 = coth k - 1/k.
std::vector<double> moments_of(double concentration, int order) {
    assert(order >= 1);
    std::vector<double> moments(static_cast<std::size_t>(order) + 1, 0.0);
    moments[0] = 1;
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

/// The moments of the distribution whose first moment is `length`; only A_0 = 1 for order 0.
std::vector<double> moments_from_first(double length, int order) {
    if (length >= 1 || order == 0)
        return std::vector<double>(static_cast<std::size_t>(order) + 1, 1.0);
    double low = 0;
    double high = 2 / (1 - length);
    for (int step = 0; step < 60; ++step) {
        const double middle = (low + high) / 2;
        (moments_of(middle, order)[1] < length ? low : high) = middle;
    }
    return moments_of((low + high) / 2, order);
}

}  // namespace

// Let p(u) be the density of energy over directions u. The covariance of the channels is
//     C_ij = integral of p Y_i Y_j = sum over k of (2 l_k + 1) A_l_k Y_k(v / |v|) g_ijk,
// for p = sum over k of (2 l_k + 1) A_l_k Y_k(v / |v|) Y_k(u) / (4 pi), where g_ijk is the mean of
// Y_i Y_j Y_k over the sphere (Gaunt).
DirectionalCovariance::DirectionalCovariance(int order)
    : order_(order), channels_(static_cast<std::size_t>((order + 1) * (order + 1))) {
    assert(order >= 0 && order <= kHighestOrder);
    const int twice = 2 * order;
    const auto harmonics = static_cast<std::size_t>((twice + 1) * (twice + 1));
    const Quadrature sphere(twice + 1);
    std::vector<std::array<double, kMaxHarmonics>> values(sphere.directions.size());
    for (std::size_t q = 0; q < values.size(); ++q) {
        spherical_harmonics(sphere.directions[q], twice, values[q].data());
    }
    for (std::size_t i = 0; i < channels_; ++i) {
        for (std::size_t j = 0; j <= i; ++j) {
            std::vector<Term>& terms = products_.emplace_back();
            for (std::size_t k = 0; k < harmonics; ++k) {
                double mean = 0;
                for (std::size_t q = 0; q < values.size(); ++q) {
                    mean += sphere.weights[q] * values[q][i] * values[q][j] * values[q][k];
                }
                constexpr double kRounding = 1e-6;  // of the directions, single precision
                if (std::abs(mean) < kRounding) continue;
                terms.push_back({static_cast<std::uint32_t>(k), mean * (2 * order_of(k) + 1)});
            }
        }
    }
    for (std::size_t n = 0; n <= kLengths; ++n) {
        moments_.push_back(moments_from_first(static_cast<double>(n) / kLengths, twice));
    }
}

// Cholesky decomposition C = L L^T. W is the first channel and has the energy 1: it equals the
// first noise for all directions.
void DirectionalCovariance::mixing(const Vec3& mean, float* triangle) const {
    const double length = std::min(double{glm::length(mean)}, 1.0);
    const Vec3 direction = length > 0 ? mean / static_cast<float>(length) : Vec3{0, 0, 1};
    std::array<double, kMaxHarmonics> harmonics;
    spherical_harmonics(direction, 2 * order_, harmonics.data());
    const double position = length * kLengths;
    const std::size_t below = std::min(static_cast<std::size_t>(position), kLengths - 1);
    const double share = position - static_cast<double>(below);
    for (int l = 0, k = 0; l <= 2 * order_; ++l) {
        const auto order = static_cast<std::size_t>(l);
        // Linear interpolation of the table: a mixture of two distributions.
        const double moment =
            (1 - share) * moments_[below][order] + share * moments_[below + 1][order];
        for (int m = -l; m <= l; ++m, ++k) harmonics[static_cast<std::size_t>(k)] *= moment;
    }

    std::array<std::array<double, kMaxChannels>, kMaxChannels> lower;
    std::array<double, kMaxChannels> inverse;
    std::size_t pair = 0;
    for (std::size_t i = 0; i < channels_; ++i) {
        for (std::size_t j = 0; j <= i; ++j, ++pair) {
            double c = 0;
            for (const Term& term : products_[pair]) c += term.factor * harmonics[term.harmonic];
            for (std::size_t k = 0; k < j; ++k) c -= lower[i][k] * lower[j][k];
            if (i == j) {
                // For a single direction the matrix has rank 1, and what remains of it is rounding:
                // below 6e-6 (directional_covariance_test.cpp). As a pivot, it would be amplified.
                constexpr double kNothing = 1e-5;
                lower[i][i] = c > kNothing ? std::sqrt(c) : 0;
                inverse[i] = c > kNothing ? 1 / lower[i][i] : 0;
            } else {
                lower[i][j] = c * inverse[j];
            }
            triangle[pair] = static_cast<float>(lower[i][j]);
        }
    }
}

}  // namespace aula
