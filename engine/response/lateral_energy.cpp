#include "engine/response/lateral_energy.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <vector>

#include "engine/response/decay_curve.h"
#include "engine/response/time_zero.h"

namespace aula {

namespace {

// ISO 3382-1:2009, A.2.4.
constexpr double kDirect_s = 0.005;
constexpr double kEarly_s = 0.08;

/// Mean of |a + b cos(phi)| over phi, for b >= 0.
double mean_magnitude(double a, double b) {
    a = std::abs(a);
    if (a >= b) return a;
    return 2 / std::numbers::pi * (a * std::asin(a / b) + std::sqrt(b * b - a * a));
}

/// Concentration k of the von Mises-Fisher distribution with the mean length coth k - 1/k.
double concentration_of(double length) {
    double low = 0;
    double high = 2 / (1 - length);
    for (int step = 0; step < 60; ++step) {
        const double k = (low + high) / 2;
        const double mean = k < 1e-3 ? k / 3 : 1 / std::tanh(k) - 1 / k;
        (mean < length ? low : high) = k;
    }
    return (low + high) / 2;
}

/// The mean of the cosine's magnitude over the root of the mean of its square, for directions that
/// have the von Mises-Fisher distribution.
class AxialMeans {
 public:
    AxialMeans() : magnitude_((kSteps + 1) * (kSteps + 1)), square_(kSteps + 1) {
        for (std::size_t i = 0; i <= kSteps; ++i) {
            const double length = static_cast<double>(i) / kSteps;
            const std::vector<double> cosines = along_mean(length);
            for (const double t : cosines) square_[i] += t * t / kPoints;
            for (std::size_t j = 0; j <= kSteps; ++j) {
                const double c = static_cast<double>(j) / kSteps;
                double sum = 0;
                for (const double t : cosines)
                    sum += mean_magnitude(t * c, std::sqrt((1 - t * t) * (1 - c * c)));
                magnitude_[i * (kSteps + 1) + j] = sum / kPoints;
            }
        }
    }

    /// `length`: of the mean of the unit directions, 0..1; `cosine`: of its angle to the axis.
    double ratio(double length, double cosine) const {
        const double c = std::min(std::abs(cosine), 1.0);
        const auto [i, x] = cell(length);
        const auto [j, y] = cell(c);
        const std::size_t first = i * (kSteps + 1) + j;
        const auto value = [&](std::size_t di, std::size_t dj) {
            return magnitude_[first + di * (kSteps + 1) + dj];
        };
        const double magnitude = (1 - x) * ((1 - y) * value(0, 0) + y * value(0, 1)) +
                                 x * ((1 - y) * value(1, 0) + y * value(1, 1));
        // With the mean q of the squared cosine of the angle to the mean direction.
        const double q = (1 - x) * square_[i] + x * square_[i + 1];
        const double square = q * c * c + (1 - q) * (1 - c * c) / 2;
        return square > 0 ? magnitude / std::sqrt(square) : 1;
    }

 private:
    // Of the table of a smooth function, and of the distribution that it is the mean over.
    static constexpr std::size_t kSteps = 64;
    static constexpr int kPoints = 256;

    /// Cosines of the angle to the mean direction, at equal steps of their distribution.
    static std::vector<double> along_mean(double length) {
        std::vector<double> cosines(kPoints, 1.0);
        if (length >= 1) return cosines;
        const double k = concentration_of(length);
        for (int n = 0; n < kPoints; ++n) {
            const double share = (n + 0.5) / kPoints;
            cosines[static_cast<std::size_t>(n)] =
                k < 1e-6 ? 2 * share - 1 : 1 + std::log(share + (1 - share) * std::exp(-2 * k)) / k;
        }
        return cosines;
    }

    struct Cell {
        std::size_t below;
        double share;
    };
    static Cell cell(double x) {
        const double position = std::clamp(x, 0.0, 1.0) * kSteps;
        const auto below = std::min(static_cast<std::size_t>(position), kSteps - 1);
        return {below, position - static_cast<double>(below)};
    }

    std::vector<double> magnitude_;  ///< [length * (kSteps + 1) + cosine]
    std::vector<double> square_;     ///< [length]
};

const AxialMeans& axial_means() {
    static const AxialMeans means;
    return means;
}

/// The part of a bin within [from_s, to_s), 0..1.
double overlap(double begin_s, double end_s, double from_s, double to_s) {
    return std::max(0.0, std::min(end_s, to_s) - std::max(begin_s, from_s)) / (end_s - begin_s);
}

}  // namespace

std::array<LateralParameters, kBandCount> lateral_parameters(const EnergyResponse& response,
                                                             const Vec3& axis) {
    using Sums = std::array<double, kBandCount>;
    Sums early{}, early_lateral{}, early_cosine{}, late_lateral{};
    const auto add = [](Sums& sums, double factor, const Bands& energy) {
        for (std::size_t b = 0; b < kBandCount; ++b) sums[b] += factor * double{energy[b]};
    };
    const double zero_s = time_zero_s(response);
    const double infinity = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < response.bins.count(); ++i) {
        const float sum = response.energy[i].sum();
        if (!(sum > 0)) continue;
        const double begin_s = response.bins.begin_s(i) - zero_s;
        const double end_s = response.bins.end_s(i) - zero_s;
        const DirectionMoments mean = response.directions[i] / sum;
        const double length = std::min(double{glm::length(mean.intensity)}, 1.0);
        const double cosine = length > 0 ? double{glm::dot(mean.intensity, axis)} / length : 0;
        const double square = std::clamp(1.0 / 3 + double{mean.along(axis)}, 0.0, 1.0);
        const double magnitude = axial_means().ratio(length, cosine) * std::sqrt(square);
        const Bands& energy = response.energy[i];
        add(early, overlap(begin_s, end_s, -infinity, kEarly_s), energy);
        const double lateral = overlap(begin_s, end_s, kDirect_s, kEarly_s);
        add(early_lateral, lateral * square, energy);
        add(early_cosine, lateral * magnitude, energy);
        add(late_lateral, overlap(begin_s, end_s, kEarly_s, infinity) * square, energy);
    }
    for (const SoundPath& path : response.paths) {
        const double time_s = response.arrival_s(path) - zero_s;
        if (response.arrival_s(path) >= response.bins.length_s()) continue;
        const double cosine = std::abs(double{glm::dot(path.direction, axis)});
        if (time_s >= kEarly_s) {
            add(late_lateral, cosine * cosine, path.energy);
            continue;
        }
        add(early, 1, path.energy);
        if (time_s < kDirect_s) continue;
        add(early_lateral, cosine * cosine, path.energy);
        add(early_cosine, cosine, path.energy);
    }
    std::array<LateralParameters, kBandCount> bands;
    for (std::size_t b = 0; b < kBandCount; ++b) {
        if (early[b] > 0) {
            bands[b].jlf = early_lateral[b] / early[b];
            bands[b].jlfc = early_cosine[b] / early[b];
        }
        if (late_lateral[b] > 0) bands[b].lj_db = 10 * std::log10(kStrength_m2 * late_lateral[b]);
    }
    return bands;
}

}  // namespace aula
