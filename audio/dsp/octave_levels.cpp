#include "audio/dsp/octave_levels.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>

#include "process/multiversion.h"

namespace aula {

namespace {

// Octaves of more independent samples have the level of their band.
constexpr double kNarrow_samples = 6;

// Of Newton's method. The second step leaves hundredths of a decibel in ordinary materials.
constexpr int kMostSteps = 3;
constexpr float kSolved_db = 0.02F;
// Of one step, in the natural logarithm of an energy: 6.5 dB.
constexpr double kLongestStep = 1.5;

constexpr float kLowestOctaveGain = 1e-3F;  // re the greatest

/// A node of a quadrature and its weight.
struct Node {
    double x;
    double weight;
};

/// Gauss-Legendre quadrature of the mean over -1..1.
std::vector<Node> gauss_nodes(unsigned count) {
    std::vector<Node> nodes;
    for (unsigned i = 0; i < count; ++i) {
        double x = std::cos(std::numbers::pi * (i + 0.75) / (count + 0.5));
        double slope = 0;
        for (int step = 0; step < 5; ++step) {  // converges quadratically from 1e-2
            const double value = std::legendre(count, x);
            slope = count * (x * value - std::legendre(count - 1, x)) / (x * x - 1);
            x -= value / slope;
        }
        nodes.push_back({x, 1 / ((1 - x * x) * slope * slope)});
    }
    return nodes;
}

AULA_MULTIVERSION
float product(const float* __restrict a, const float* __restrict b, std::size_t count) {
    constexpr std::size_t kLanes = 16;
    std::array<float, kLanes> sum{};
    for (std::size_t n = 0; n + kLanes <= count; n += kLanes)
        for (std::size_t i = 0; i < kLanes; ++i) sum[i] += a[n + i] * b[n + i];
    float rest = 0;
    for (std::size_t n = count - count % kLanes; n < count; ++n) rest += a[n] * b[n];
    for (std::size_t i = 0; i < 8; ++i) sum[i] += sum[i + 8];
    for (std::size_t i = 0; i < 4; ++i) sum[i] += sum[i + 4];
    return (sum[0] + sum[2]) + (sum[1] + sum[3]) + rest;
}

AULA_MULTIVERSION
void add_scaled(float factor, const float* __restrict x, float* __restrict sum, std::size_t count) {
    for (std::size_t n = 0; n < count; ++n) sum[n] += factor * x[n];
}

}  // namespace

OctaveLevels::OctaveLevels(double sample_rate_hz, std::size_t taps) : taps_(taps), best_(taps) {
    std::size_t row = 0;
    for (std::size_t band = 0; band < 8; ++band) {
        const double low_hz = 62.5 * std::exp2(static_cast<double>(band) - 0.5);
        const double width_samples = low_hz * static_cast<double>(taps) / sample_rate_hz;
        if (width_samples > kNarrow_samples || 2 * low_hz > sample_rate_hz / 2) break;
        // The squared magnitude is a trigonometric polynomial: of half a cycle over the octave for
        // each independent sample.
        const auto nodes = gauss_nodes(3 + static_cast<unsigned>(std::ceil(1.5 * width_samples)));
        octaves_.push_back({row, row + 2 * nodes.size()});
        row += 2 * nodes.size();
        for (const Node& node : nodes) {
            const double frequency_hz = low_hz * (1.5 + 0.5 * node.x);
            const double w = 2 * std::numbers::pi * frequency_hz / sample_rate_hz;
            for (const double phase : {0.0, std::numbers::pi / 2})
                for (std::size_t n = 0; n < taps; ++n)
                    rows_.push_back(static_cast<float>(
                        std::sqrt(node.weight) * std::cos(w * static_cast<double>(n) - phase)));
        }
    }
    wanted_.resize(octaves_.size());
    energy_.resize(octaves_.size());
    gradients_.resize(octaves_.size() * taps);
    normal_.resize(octaves_.size() * octaves_.size());
}

// The energy of octave b is E_b = |R_b h|^2 for the rows R_b, with the gradient 2 R_b^T R_b h.
float OctaveLevels::measure(const std::array<float, 8>& energies, std::span<const float> response) {
    std::fill(gradients_.begin(), gradients_.end(), 0.0F);
    double worst = 0;
    for (std::size_t b = 0; b < octaves_.size(); ++b) {
        float* const gradient = gradients_.data() + b * taps_;
        energy_[b] = 0;
        for (std::size_t row = octaves_[b].first_row; row < octaves_[b].end_row; ++row) {
            const float* const wave = rows_.data() + row * taps_;
            const float part = best_version<product>(wave, response.data(), taps_);
            energy_[b] += double{part} * double{part};
            best_version<add_scaled>(part, wave, gradient, taps_);
        }
        energy_[b] = std::max(energy_[b], 1e-30);
        wanted_[b] = std::log(double{energies[b]} / energy_[b]);
        if (!std::isfinite(wanted_[b])) return std::numeric_limits<float>::infinity();
        worst = std::max(worst, std::abs(wanted_[b]));
    }
    return static_cast<float>(10 / std::numbers::ln10 * worst);
}

// A step of Newton's method for ln E_b = ln g_b^2 with the smallest change of the response:
// h += J^T (J J^T)^-1 r, where J has the rows 2 R_b^T R_b h / E_b and r is what the logarithms
// lack.
void OctaveLevels::step(std::span<float> response) {
    const std::size_t count = octaves_.size();
    const auto gradient = [&](std::size_t b) { return gradients_.data() + b * taps_; };
    for (std::size_t b = 0; b < count; ++b)
        for (std::size_t c = 0; c <= b; ++c)
            normal_[b * count + c] =
                4 * double{best_version<product>(gradient(b), gradient(c), taps_)} /
                (energy_[b] * energy_[c]);
    // Cholesky factorisation in place, with a small part of the diagonal against rounding.
    std::vector<double>& x = wanted_;
    for (std::size_t b = 0; b < count; ++b) {
        double* const row = normal_.data() + b * count;
        x[b] = std::clamp(x[b], -kLongestStep, kLongestStep);
        for (std::size_t c = 0; c <= b; ++c) {
            const double* const other = normal_.data() + c * count;
            for (std::size_t i = 0; i < c; ++i) row[c] -= row[i] * other[i];
            row[c] = c < b ? row[c] / other[c]
                           : std::sqrt(std::max(row[c], 0.0) + 1e-6 * std::abs(row[c]) + 1e-12);
        }
        for (std::size_t c = 0; c < b; ++c) x[b] -= row[c] * x[c];
        x[b] /= row[b];
    }
    for (std::size_t b = count; b-- > 0;) {
        for (std::size_t c = b + 1; c < count; ++c) x[b] -= normal_[c * count + b] * x[c];
        x[b] /= normal_[b * count + b];
    }
    for (std::size_t b = 0; b < count; ++b)
        best_version<add_scaled>(static_cast<float>(2 * x[b] / energy_[b]), gradient(b),
                                 response.data(), taps_);
}

float OctaveLevels::correct(const std::array<float, 8>& gains, std::span<float> response) {
    assert(response.size() == taps_);
    const float greatest = *std::max_element(gains.begin(), gains.end());
    if (!(greatest >= std::numeric_limits<float>::min())) return 0;
    // Paths that fade out have gains whose squares are not numbers of single precision. A power of
    // two scales them without rounding.
    const float unit = std::ldexp(1.0F, std::ilogb(greatest));
    for (float& x : response) x /= unit;
    std::array<float, 8> energies{};
    for (std::size_t b = 0; b < energies.size(); ++b) {
        const float gain = std::max(gains[b], kLowestOctaveGain * greatest) / unit;
        energies[b] = gain * gain;
    }
    float error_db = measure(energies, response);
    float least_db = error_db;
    std::copy(response.begin(), response.end(), best_.begin());
    for (int i = 0; i < kMostSteps && error_db > kSolved_db; ++i) {
        step(response);
        error_db = measure(energies, response);
        if (error_db >= least_db) continue;
        least_db = error_db;
        std::copy(response.begin(), response.end(), best_.begin());
    }
    for (std::size_t n = 0; n < taps_; ++n) response[n] = unit * best_[n];
    return least_db;
}

}  // namespace aula
