#include "apps/bench/base/statistics.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <numeric>

namespace aula::bench {

namespace {

constexpr std::size_t kFirstLateBin = 5;
constexpr std::size_t kEndBin = 50;

/// Calls `visit(first)` with the first bin of each whole group; returns the number of groups.
template <typename Visit>
std::size_t for_each_group(BinRange bins, const Visit& visit) {
    std::size_t groups = 0;
    for (std::size_t b = bins.first; b + kGroupBins <= bins.end; b += kGroupBins, ++groups) {
        visit(b);
    }
    return groups;
}

}  // namespace

BinRange late_bins(std::size_t bin_count) {
    const std::size_t end = std::min(kEndBin, bin_count);
    return {std::min(kFirstLateBin, end), end};
}

BinRange audible_bins(std::span<const double> reference) {
    constexpr double kAudible = 1e-3;
    BinRange bins = late_bins(reference.size());
    const auto late = reference.subspan(bins.first, bins.count());
    if (late.empty()) return bins;
    const double audible = kAudible * *std::max_element(late.begin(), late.end());
    const auto is_faint = [&](std::size_t first) {
        const auto group = reference.subspan(first, kGroupBins);
        return !(*std::min_element(group.begin(), group.end()) >= audible);
    };
    while (bins.count() >= 2 * kGroupBins && is_faint(bins.first)) bins.first += kGroupBins;
    return bins;
}

std::vector<double> estimated_energy(const EnergyResponse& response) {
    EnergyResponse found = response;
    std::erase_if(found.paths, [](const SoundPath& path) { return path.order == 0; });
    const std::vector<Bands> uniform = found.uniform(kBin_s);
    // The last bin may be longer than the response.
    const auto whole = static_cast<std::size_t>(response.bins.length_s() / kBin_s + 1e-6);
    std::vector<double> energy;
    for (std::size_t i = 0; i < std::min(kEndBin, whole); ++i) {
        energy.push_back(double{uniform[i].sum()});
    }
    return energy;
}

std::vector<Vec3> estimated_direction(const EnergyResponse& response) {
    const TimeBins& bins = response.bins;
    constexpr double kGroup_s = kBin_s * kGroupBins;
    std::vector<Vec3> groups(kEndBin / kGroupBins, Vec3(0));
    for (std::size_t i = 0; i < bins.count(); ++i) {
        for (std::size_t g = 0; g < groups.size(); ++g) {
            const double begin_s = std::max(bins.begin_s(i), static_cast<double>(g) * kGroup_s);
            const double end_s = std::min(bins.end_s(i), static_cast<double>(g + 1) * kGroup_s);
            if (end_s <= begin_s) continue;
            groups[g] += response.directions[i].intensity *
                         static_cast<float>((end_s - begin_s) / (bins.end_s(i) - bins.begin_s(i)));
        }
    }
    for (const SoundPath& path : response.paths) {
        const auto group = static_cast<std::size_t>(response.arrival_s(path) / kGroup_s);
        if (path.order == 0 || group >= groups.size()) continue;
        groups[group] += path.energy.sum() * path.direction;
    }
    return groups;
}

double relative_deviation(const std::vector<std::vector<double>>& restarts, BinRange bins) {
    assert(restarts.size() >= 2);
    const auto n = static_cast<double>(restarts.size());
    double sum = 0;
    std::size_t counted = 0;
    for (std::size_t b = bins.first; b < bins.end; ++b) {
        double mean = 0;
        for (const auto& energy : restarts) mean += energy[b] / n;
        if (!(mean > 0)) continue;
        double squares = 0;
        for (const auto& energy : restarts) squares += (energy[b] - mean) * (energy[b] - mean);
        sum += std::sqrt(squares / (n - 1)) / mean;
        ++counted;
    }
    return counted > 0 ? sum / static_cast<double>(counted) : 0;
}

double direction_deviation_deg(const std::vector<std::vector<Vec3>>& restarts, BinRange bins) {
    assert(restarts.size() >= 2);
    double sum_deg = 0;
    const std::size_t groups = for_each_group(bins, [&](std::size_t first_bin) {
        const std::size_t g = first_bin / kGroupBins;
        Vec3 mean(0);
        for (const auto& direction : restarts) mean += direction[g];
        double squares = 0;
        for (const auto& direction : restarts) {
            // The arc tangent is precise for small angles. A restart without energy counts as
            // a right angle.
            const float along = glm::dot(direction[g], mean);
            const float across = glm::length(glm::cross(direction[g], mean));
            const double angle_rad = along == 0 && across == 0
                                         ? std::numbers::pi / 2
                                         : std::atan2(double{across}, double{along});
            squares += angle_rad * angle_rad;
        }
        sum_deg += std::sqrt(squares / (static_cast<double>(restarts.size()) - 1)) * 180 /
                   std::numbers::pi;
    });
    return groups > 0 ? sum_deg / static_cast<double>(groups) : 0;
}

double energy_ratio(const std::vector<std::vector<double>>& restarts,
                    std::span<const double> reference, BinRange bins) {
    double sum = 0;
    const std::size_t groups = for_each_group(bins, [&](std::size_t first_bin) {
        double energy = 0;
        double wanted = 0;
        for (std::size_t b = first_bin; b < first_bin + kGroupBins; ++b) {
            for (const auto& restart : restarts) energy += restart[b];
            wanted += reference[b];
        }
        sum += energy / static_cast<double>(restarts.size()) / wanted;
    });
    return groups > 0 ? sum / static_cast<double>(groups) : 0;
}

BinRange bins_from_peak(std::span<const double> reference) {
    const auto peak = std::max_element(reference.begin(), reference.end());
    return {static_cast<std::size_t>(peak - reference.begin()), reference.size()};
}

double squared_relative_error(std::span<const double> energy, std::span<const double> reference,
                              BinRange bins) {
    double sum = 0;
    for (std::size_t b = bins.first; b < bins.end; ++b) {
        const double error = energy[b] / reference[b] - 1;
        sum += error * error;
    }
    return sum;
}

double mean(std::span<const double> values) {
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double median(std::vector<double> values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

double standard_error(std::span<const double> values) {
    const auto n = static_cast<double>(values.size());
    const double middle = mean(values);
    double squares = 0;
    for (const double value : values) squares += (value - middle) * (value - middle);
    return std::sqrt(squares / (std::max(1.0, n - 1) * n));
}

double without_reference_error(double error, double reference_error) {
    return std::sqrt(std::max(0.0, error * error - reference_error * reference_error));
}

}  // namespace aula::bench
