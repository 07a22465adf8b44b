#include "engine/response/open_plan.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

namespace aula {

namespace {

/// IEC 61672-1, table 3, 63 Hz to 8 kHz.
constexpr std::array<double, kBandCount> kAWeights_db{-26.2, -16.1, -8.6, -3.2, 0, 1.2, 1, -1.1};

/// The receivers at distances that count, on one floor in the direction in which most of them are.
std::vector<std::size_t> longest_line(std::span<const SpeechAtReceiver> receivers) {
    const auto counts = [&](std::size_t i) {
        const double distance_m = receivers[i].distance_m();
        return distance_m >= kOpenPlanFrom_m && distance_m <= kOpenPlanTo_m;
    };
    const double least_cosine = std::cos(kOpenPlanAngle_deg * std::numbers::pi / 180);
    const auto is_level = [](const SpeechAtReceiver& a, const SpeechAtReceiver& b) {
        return std::abs(double{a.from_talker_m.z - b.from_talker_m.z}) <= kOpenPlanLevel_m;
    };
    std::vector<std::size_t> longest;
    for (std::size_t middle = 0; middle < receivers.size(); ++middle) {
        if (!counts(middle)) continue;
        const Vec3 direction = glm::normalize(receivers[middle].from_talker_m);
        std::vector<std::size_t> line;
        for (std::size_t i = 0; i < receivers.size(); ++i)
            if (counts(i) && is_level(receivers[i], receivers[middle]) &&
                double{glm::dot(glm::normalize(receivers[i].from_talker_m), direction)} >=
                    least_cosine)
                line.push_back(i);
        if (line.size() > longest.size()) longest = std::move(line);
    }
    return longest;
}

struct RegressionLine {
    double offset = 0, slope = 0;

    /// Where the line falls to a value; empty if it does not, or does so before the talker.
    std::optional<double> falls_to(double value) const {
        if (!(slope < 0)) return std::nullopt;
        const double x = (value - offset) / slope;
        return x > 0 ? std::optional(x) : std::nullopt;
    }
};

/// The least-squares line through points (x, y) that differ in x.
RegressionLine line_through(const std::vector<std::array<double, 2>>& points) {
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
    const double slope = covariance / variance;
    return RegressionLine{mean_y - slope * mean_x, slope};
}

}  // namespace

double a_weighted_db(const Bands& levels_db) {
    double power = 0;
    for (std::size_t b = 0; b < kBandCount; ++b)
        power += std::pow(10, (double{levels_db[b]} + kAWeights_db[b]) / 10);
    return 10 * std::log10(power);
}

std::optional<OpenPlanParameters> open_plan_parameters(
    std::span<const SpeechAtReceiver> receivers) {
    std::vector<std::size_t> on_line = longest_line(receivers);
    if (on_line.size() < kOpenPlanReceivers) return std::nullopt;
    std::vector<std::array<double, 2>> levels;   // over log2 of the distance
    std::vector<std::array<double, 2>> indices;  // over the distance
    double nearest_m = std::numeric_limits<double>::infinity();
    double farthest_m = 0;
    for (const std::size_t i : on_line) {
        const SpeechAtReceiver& receiver = receivers[i];
        const double distance_m = receiver.distance_m();
        nearest_m = std::min(nearest_m, distance_m);
        farthest_m = std::max(farthest_m, distance_m);
        levels.push_back({std::log2(distance_m), receiver.level_dba});
        if (receiver.sti) indices.push_back({distance_m, *receiver.sti});
    }
    if (farthest_m < kOpenPlanRatio * nearest_m) return std::nullopt;
    const RegressionLine level = line_through(levels);
    OpenPlanParameters parameters{.d2s_db = -level.slope,
                                  .lp_as_4m_dba = level.offset + level.slope * std::log2(4.0),
                                  .rd_m = {},
                                  .rp_m = {},
                                  .line = std::move(on_line)};
    if (indices.size() < levels.size()) return parameters;
    const RegressionLine index = line_through(indices);
    // ISO 3382-3.
    constexpr double kDistraction = 0.5;
    constexpr double kPrivacy = 0.2;
    parameters.rd_m = index.falls_to(kDistraction);
    parameters.rp_m = index.falls_to(kPrivacy);
    return parameters;
}

}  // namespace aula
