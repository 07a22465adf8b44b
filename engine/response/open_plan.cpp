#include "engine/response/open_plan.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace aula {

namespace {

/// IEC 61672-1, table 3, 63 Hz to 8 kHz.
constexpr std::array<double, kBandCount> kAWeights_db{-26.2, -16.1, -8.6, -3.2, 0, 1.2, 1, -1.1};

bool counts(const SpeechAtReceiver& receiver) {
    return receiver.distance_m >= kOpenPlanFrom_m && receiver.distance_m <= kOpenPlanTo_m;
}

struct Line {
    double offset = 0, slope = 0;

    /// Where the line falls to a value; empty if it does not, or does so before the talker.
    std::optional<double> falls_to(double value) const {
        if (!(slope < 0)) return std::nullopt;
        const double x = (value - offset) / slope;
        return x > 0 ? std::optional(x) : std::nullopt;
    }
};

/// The least-squares line through points (x, y); empty if all x are equal.
std::optional<Line> line_through(const std::vector<std::array<double, 2>>& points) {
    const auto count = static_cast<double>(points.size());
    double mean_x = 0;
    double mean_y = 0;
    for (const auto& [x, y] : points) {
        mean_x += x / count;
        mean_y += y / count;
    }
    double covariance = 0;
    double variance = 0;
    for (const auto& [x, y] : points) {
        covariance += (x - mean_x) * (y - mean_y);
        variance += (x - mean_x) * (x - mean_x);
    }
    // Distances that differ by less than rounding are equal.
    if (!(variance > 1e-9 * count)) return std::nullopt;
    const double slope = covariance / variance;
    return Line{mean_y - slope * mean_x, slope};
}

}  // namespace

double a_weighted_db(const Bands& levels_db) {
    double power = 0;
    for (std::size_t b = 0; b < kBandCount; ++b)
        power += std::pow(10, (double{levels_db[b]} + kAWeights_db[b]) / 10);
    return 10 * std::log10(power);
}

std::size_t open_plan_receivers(std::span<const SpeechAtReceiver> receivers) {
    return static_cast<std::size_t>(std::count_if(receivers.begin(), receivers.end(), counts));
}

std::optional<OpenPlanParameters> open_plan_parameters(
    std::span<const SpeechAtReceiver> receivers) {
    std::vector<std::array<double, 2>> levels;   // over log2 of the distance
    std::vector<std::array<double, 2>> indices;  // over the distance
    for (const SpeechAtReceiver& receiver : receivers) {
        if (!counts(receiver)) continue;
        levels.push_back({std::log2(receiver.distance_m), receiver.level_dba});
        if (receiver.sti) indices.push_back({receiver.distance_m, *receiver.sti});
    }
    if (levels.size() < kOpenPlanReceivers) return std::nullopt;
    const std::optional<Line> level = line_through(levels);
    if (!level) return std::nullopt;
    OpenPlanParameters parameters{.d2s_db = -level->slope,
                                  .lp_as_4m_dba = level->offset + level->slope * std::log2(4.0),
                                  .rd_m = {},
                                  .rp_m = {}};
    const std::optional<Line> index =
        indices.size() == levels.size() ? line_through(indices) : std::nullopt;
    if (!index) return parameters;
    constexpr double kDistraction = 0.5;
    constexpr double kPrivacy = 0.2;
    parameters.rd_m = index->falls_to(kDistraction);
    parameters.rp_m = index->falls_to(kPrivacy);
    return parameters;
}

}  // namespace aula
