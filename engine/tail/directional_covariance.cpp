#include "engine/tail/directional_covariance.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <numbers>

#include "engine/base/spherical_harmonics.h"
#include "engine/tail/zonal_moments.h"

namespace aula {
namespace {

constexpr int kHighestOrder = 3;
constexpr std::size_t kMaxChannels = (kHighestOrder + 1) * (kHighestOrder + 1);
/// Harmonics up to twice the order.
constexpr std::size_t kMaxHarmonics = (2 * kHighestOrder + 1) * (2 * kHighestOrder + 1);

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

/// The eigenvalues of a symmetric matrix in descending order, and its unit eigenvectors.
struct PrincipalAxes {
    std::array<double, 3> value;
    std::array<Vec3, 3> direction;
};

using Matrix = std::array<std::array<double, 3>, 3>;

/// By Jacobi's rotations.
PrincipalAxes principal_axes(Matrix m) {
    std::array<glm::dvec3, 3> axes{glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0), glm::dvec3(0, 0, 1)};
    for (int sweep = 0; sweep < 4; ++sweep) {
        for (std::size_t p = 0; p < 2; ++p) {
            for (std::size_t q = p + 1; q < 3; ++q) {
                if (m[p][q] == 0) continue;
                const double half = (m[q][q] - m[p][p]) / (2 * m[p][q]);
                const double tangent =
                    (half < 0 ? -1 : 1) / (std::abs(half) + std::sqrt(half * half + 1));
                const double cosine = 1 / std::sqrt(tangent * tangent + 1);
                const double sine = tangent * cosine;
                for (std::size_t k = 0; k < 3; ++k) {
                    const double at_p = m[k][p];
                    m[k][p] = cosine * at_p - sine * m[k][q];
                    m[k][q] = sine * at_p + cosine * m[k][q];
                }
                for (std::size_t k = 0; k < 3; ++k) {
                    const double at_p = m[p][k];
                    m[p][k] = cosine * at_p - sine * m[q][k];
                    m[q][k] = sine * at_p + cosine * m[q][k];
                }
                const glm::dvec3 axis = axes[p];
                axes[p] = cosine * axis - sine * axes[q];
                axes[q] = sine * axis + cosine * axes[q];
            }
        }
    }
    std::array<std::size_t, 3> order{0, 1, 2};
    std::sort(order.begin(), order.end(),
              [&](std::size_t a, std::size_t b) { return m[a][a] > m[b][b]; });
    PrincipalAxes sorted{};
    for (std::size_t i = 0; i < 3; ++i) {
        sorted.value[i] = m[order[i]][order[i]];
        sorted.direction[i] = Vec3(axes[order[i]]);
    }
    return sorted;
}

/// The matrix of the means of u_i u_j.
Matrix second_moments(const DirectionMoments& mean) {
    constexpr double kThird = 1.0 / 3;
    const double xx{mean.xx};
    const double yy{mean.yy};
    const double xy{mean.xy};
    const double yz{mean.yz};
    const double zx{mean.zx};
    return {{{kThird + xx, xy, zx}, {xy, kThird + yy, yz}, {zx, yz, kThird - xx - yy}}};
}

/// The harmonics of degree 1 and 2, from 1 on.
void set_low_degrees(const DirectionMoments& mean, double* harmonics) {
    const double root3 = std::sqrt(3.0);
    harmonics[1] = double{mean.intensity.y};
    harmonics[2] = double{mean.intensity.z};
    harmonics[3] = double{mean.intensity.x};
    harmonics[4] = root3 * double{mean.xy};
    harmonics[5] = root3 * double{mean.yz};
    harmonics[6] = -1.5 * double{mean.xx + mean.yy};
    harmonics[7] = root3 * double{mean.zx};
    harmonics[8] = root3 / 2 * double{mean.xx - mean.yy};
}

}  // namespace

// Let p(u) be the density of energy over directions u. The covariance of the channels is
//     C_ij = integral of p Y_i Y_j = sum over k of (2 l_k + 1) m_k g_ijk,
// for p = sum over k of (2 l_k + 1) m_k Y_k(u) / (4 pi), where g_ijk is the mean of Y_i Y_j Y_k
// over the sphere (Gaunt). The moments m_k of degree 1 and 2 are given: they suffice up to order 1.
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
    const auto products = [&](std::size_t i, std::size_t j) {
        std::vector<Term> terms;
        for (std::size_t k = 0; k < harmonics; ++k) {
            double mean = 0;
            for (std::size_t q = 0; q < values.size(); ++q) {
                mean += sphere.weights[q] * values[q][i] * values[q][j] * values[q][k];
            }
            constexpr double kRounding = 1e-6;  // of the directions, single precision
            if (std::abs(mean) < kRounding) continue;
            terms.push_back({static_cast<std::uint32_t>(k), mean * (2 * order_of(k) + 1)});
        }
        return terms;
    };
    for (std::size_t i = 0; i < channels_; ++i) {
        for (std::size_t j = 0; j <= i; ++j) products_.push_back(products(i, j));
    }
    if (order < 2) return;
    for (std::size_t k = 0; k < harmonics; ++k) {
        if (order_of(k) < 3 || order_of(k) % 2 == 0) continue;
        for (const std::size_t axis : {1U, 2U, 3U}) along_axes_.push_back(products(k, axis));
    }
}

// The moments of degree 3 to 6, those of degree 1 and 2 being v and those of the matrix M of the
// means of u_i u_j, are those of
//     p(u) = q(u) (1 + c.u),  M c = v,
// which has these moments of degree 1 and 2 for any even distribution q with the second moments M.
// With the eigenvalues a >= b >= c of M and the axes e_a and e_c,
//     q = [(a - b) W(u.e_a; s) + 2 (b - c) W(u.e_c; -s/2)] / s,  s = 1 - 3 c,
// where W(x; A) ~ exp(k x^2) is Watson's distribution, that of greatest entropy about an axis for
// the mean A of P_2(x): the harmonics of degree 2 of the sum are those of M. Where two eigenvalues
// are equal, q is the distribution of greatest entropy. Where sound comes from few directions,
// 1 + c.u would be negative in others. p is therefore used relative to the von Mises-Fisher
// distribution with the mean v, whose moments are added and those of p for its M subtracted.
void DirectionalCovariance::set_high_degrees(const DirectionMoments& directions,
                                             double* harmonics) const {
    const ZonalMoments& zonal = ZonalMoments::shared();
    const Vec3 v = directions.intensity;
    const PrincipalAxes axes = principal_axes(second_moments(directions));
    const auto [a, b, c] = axes.value;
    const double s = std::clamp(1 - 3 * c, 0.0, 1.0);
    const double length{std::min(glm::length(v), 1.0F)};
    const double share = a - b + 2 * (b - c) > 0 ? (a - b) / (a - b + 2 * (b - c)) : 0;

    std::array<std::array<double, kMaxHarmonics>, 3> values;
    const int degree = 2 * order_;
    const auto count = static_cast<std::size_t>((degree + 1) * (degree + 1));
    spherical_harmonics(axes.direction[0], degree, values[0].data());
    spherical_harmonics(axes.direction[2], degree, values[1].data());
    spherical_harmonics(length > 0 ? glm::normalize(v) : Vec3(0, 0, 1), degree, values[2].data());
    const ZonalMoments::Degrees bipolar = zonal.watson(s);
    const ZonalMoments::Degrees girdle = zonal.watson(-s / 2);
    for (std::size_t k = 9; k < count; ++k) {
        const auto l = static_cast<std::size_t>(order_of(k));
        if (l % 2 == 0)
            harmonics[k] =
                share * bipolar[l] * values[0][k] + (1 - share) * girdle[l] * values[1][k];
    }

    // A direction in which no sound arrives has no share of v but rounding.
    constexpr double kRounding = 1e-3;
    glm::dvec3 tilt(0);
    for (std::size_t i = 0; i < 3; ++i) {
        const double value = axes.value[i];
        tilt += glm::dvec3(axes.direction[i]) * double{glm::dot(v, axes.direction[i])} * value /
                (value * value + kRounding * kRounding);
    }
    auto terms = along_axes_.begin();
    for (std::size_t k = 9; k < count; ++k) {
        if (order_of(k) % 2 == 0) continue;
        double sum = 0;
        for (const double component : {tilt.y, tilt.z, tilt.x}) {
            for (const Term& term : *terms++)
                sum += component * term.factor * harmonics[term.harmonic];
        }
        harmonics[k] = sum;
    }
    const ZonalMoments::Degrees directed = zonal.directed(length);
    for (std::size_t k = 9; k < count; ++k)
        harmonics[k] += directed[static_cast<std::size_t>(order_of(k))] * values[2][k];
}

// Cholesky decomposition C = L L^T. W is the first channel and has the energy 1: it equals the
// first noise for all directions.
void DirectionalCovariance::mixing(const DirectionMoments& directions, float* triangle) const {
    std::array<double, kMaxHarmonics> harmonics{1};
    set_low_degrees(directions, harmonics.data());
    if (order_ > 1) set_high_degrees(directions, harmonics.data());

    std::array<std::array<double, kMaxChannels>, kMaxChannels> lower;
    std::array<double, kMaxChannels> inverse;
    std::size_t pair = 0;
    for (std::size_t i = 0; i < channels_; ++i) {
        double all = 0;     // the energy of the channel
        double common = 0;  // with the channels before it
        for (std::size_t j = 0; j <= i; ++j, ++pair) {
            double c = 0;
            for (const Term& term : products_[pair]) c += term.factor * harmonics[term.harmonic];
            if (i == j) all = c;
            for (std::size_t k = 0; k < j; ++k) c -= lower[i][k] * lower[j][k];
            if (i == j) break;
            lower[i][j] = c * inverse[j];
            common += lower[i][j] * lower[i][j];
        }
        // For a single direction the matrix has rank 1, and what remains of it is rounding
        // (directional_covariance_test.cpp). As a pivot, it would be amplified.
        constexpr double kNothing = 1e-5;
        const double rest = all - common;
        lower[i][i] = rest > kNothing ? std::sqrt(rest) : 0;
        inverse[i] = rest > kNothing ? 1 / lower[i][i] : 0;
        // Where the moments are those of no distribution, the channel keeps its energy.
        const double kept =
            rest < -kNothing && common > 0 ? std::sqrt(std::max(all, 0.0) / common) : 1;
        float* const row = triangle + i * (i + 1) / 2;
        for (std::size_t j = 0; j <= i; ++j) {
            lower[i][j] *= kept;
            row[j] = static_cast<float>(lower[i][j]);
        }
        pair = (i + 1) * (i + 2) / 2;
    }
}

}  // namespace aula
