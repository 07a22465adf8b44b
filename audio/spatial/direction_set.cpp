#include "audio/spatial/direction_set.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <optional>

namespace aula {

namespace {

constexpr double kPi = std::numbers::pi;

// Caps around the directions of a set cover the sphere if they have at most this many times its
// area altogether: 1.7 times for the vertices of a cube, 2.1 for those of a dodecahedron, 2.2 for a
// grid of 10 by 10 degrees, 2.6 for one of 5 by 10. A ring of six directions, which leaves the
// poles open, needs 3 times.
constexpr double kCovering = 2.8;

// Spacing of closing directions. Interaural delays change by up to 13 us per degree, and
// interpolation by half of a step beyond that.
constexpr double kSpacing_rad = 5 * kPi / 180;

// Step of the search on a cone.
constexpr double kStep_rad = 2 * kPi / 180;

double cosine(const std::array<float, 3>& a, const std::array<float, 3>& b) {
    return double{a[0]} * double{b[0]} + double{a[1]} * double{b[1]} + double{a[2]} * double{b[2]};
}

/// The angle to the nearest direction.
double nearest_rad(const Directions& directions, const std::array<float, 3>& to) {
    double greatest = -1;
    for (const auto& direction : directions) greatest = std::max(greatest, cosine(direction, to));
    return std::acos(std::min(greatest, 1.0));
}

/// `direction` turned about the axis through the ears.
std::array<float, 3> turned(const std::array<float, 3>& direction, double angle_rad) {
    const double c = std::cos(angle_rad);
    const double s = std::sin(angle_rad);
    const double x = double{direction[0]};
    const double z = double{direction[2]};
    return {static_cast<float>(c * x - s * z), direction[1], static_cast<float>(s * x + c * z)};
}

/// The weights of the measured directions at the end of a gap, and the angle to it.
struct GapEnd {
    double angle_rad = 0;
    InterpolationWeights weights;
};

/// The end of a gap from a direction in it, in one sense of rotation about the axis through the
/// ears: where the distance to the measured directions is first a minimum of at most `radius_rad`.
/// Empty if the cone has none.
std::optional<GapEnd> gap_end(const Directions& directions, const std::array<float, 3>& direction,
                              double sense, double radius_rad) {
    const auto nearest_at = [&](double angle_rad) {
        return nearest_rad(directions, turned(direction, sense * angle_rad));
    };
    double before = nearest_at(0);
    double here = nearest_at(kStep_rad);
    double angle_rad = kStep_rad;
    while (true) {
        const double next = nearest_at(angle_rad + kStep_rad);
        if (here < before && here <= next && here <= radius_rad) break;
        before = here;
        here = next;
        angle_rad += kStep_rad;
        if (angle_rad >= 2 * kPi) return std::nullopt;
    }
    // The end is at the weighted mean of the measured directions, within a step. Three iterations
    // leave less than a thousandth of the step.
    const double least_rad = std::max(angle_rad - kStep_rad, kStep_rad / 100);
    const double greatest_rad = angle_rad + kStep_rad;
    GapEnd end;
    for (int iteration = 0; iteration < 3; ++iteration) {
        const std::array<float, 3> at = turned(direction, sense * angle_rad);
        end = {angle_rad, interpolation_weights(directions, at)};
        double x = 0;
        double z = 0;
        for (std::size_t k = 0; k < end.weights.count; ++k) {
            const auto& measured = directions[end.weights.index[k]];
            x += double{end.weights.weight[k]} * double{measured[0]};
            z += double{end.weights.weight[k]} * double{measured[2]};
        }
        const double beyond_rad = std::atan2(z, x) - std::atan2(double{at[2]}, double{at[0]});
        angle_rad += sense * std::remainder(beyond_rad, 2 * kPi);
        angle_rad = std::clamp(angle_rad, least_rad, greatest_rad);
    }
    return end;
}

/// Both poles and rings of equal elevation between them, symmetric to the median plane.
Directions candidate_directions() {
    Directions candidates;
    const auto rings = static_cast<int>(std::lround(kPi / kSpacing_rad));
    for (int ring = 0; ring <= rings; ++ring) {
        const double elevation_rad = kPi * ring / rings - kPi / 2;
        const double radius = std::cos(elevation_rad);
        const bool is_pole = ring == 0 || ring == rings;
        const int count =
            is_pole ? 1 : 2 * static_cast<int>(std::ceil(kPi * radius / kSpacing_rad));
        for (int i = 0; i < count; ++i) {
            // Signed, so that both sides mirror each other bit by bit.
            const double azimuth_rad = 2 * kPi * (2 * i > count ? i - count : i) / count;
            candidates.push_back({static_cast<float>(radius * std::cos(azimuth_rad)),
                                  static_cast<float>(radius * std::sin(azimuth_rad)),
                                  static_cast<float>(std::sin(elevation_rad))});
        }
    }
    return candidates;
}

}  // namespace

std::vector<std::size_t> distinct_directions(const Directions& positions) {
    constexpr double kSame = 1e-3;  // 0.06 degrees; sets are measured at 1 degree at least
    std::vector<double> distances;
    std::vector<std::size_t> order;
    for (const auto& p : positions) {
        order.push_back(distances.size());
        distances.push_back(std::hypot(double{p[0]}, double{p[1]}, double{p[2]}));
    }
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return distances[a] > distances[b]; });
    // By their x, so that few are compared.
    std::multimap<double, std::array<double, 3>> found;
    std::vector<std::size_t> kept;
    for (const std::size_t i : order) {
        std::array<double, 3> unit{};
        for (std::size_t c = 0; c < 3; ++c) unit[c] = double{positions[i][c]} / distances[i];
        const bool is_known =
            std::any_of(found.lower_bound(unit[0] - kSame), found.upper_bound(unit[0] + kSame),
                        [&](const auto& entry) {
                            const std::array<double, 3>& other = entry.second;
                            return std::hypot(other[0] - unit[0], other[1] - unit[1],
                                              other[2] - unit[2]) < kSame;
                        });
        if (is_known) continue;
        found.emplace(unit[0], unit);
        kept.push_back(i);
    }
    std::sort(kept.begin(), kept.end());
    return kept;
}

// Modified Shepard interpolation (Franke and Little 1980) between the four nearest directions,
// weighted by (1 / angle - 1 / angle of the fifth)^2: exact at measured directions, and continuous
// where the set of neighbours changes.
InterpolationWeights interpolation_weights(const Directions& directions,
                                           const std::array<float, 3>& direction) noexcept {
    struct Neighbour {
        float distance;  // chord, a monotonic function of the angle
        std::size_t index;
    };
    // If there is no fifth direction, all four count up to the opposite one, at a chord of 2.
    std::array<Neighbour, InterpolationWeights::kMost + 1> nearest;
    nearest.fill({4, 0});
    for (std::size_t i = 0; i < directions.size(); ++i) {
        float squared = 0;
        for (std::size_t c = 0; c < 3; ++c) {
            const float difference = directions[i][c] - direction[c];
            squared += difference * difference;
        }
        if (squared >= nearest.back().distance) continue;
        std::size_t rank = InterpolationWeights::kMost;
        for (; rank > 0 && nearest[rank - 1].distance > squared; --rank) {
            nearest[rank] = nearest[rank - 1];
        }
        nearest[rank] = {squared, i};
    }
    for (Neighbour& neighbour : nearest) neighbour.distance = std::sqrt(neighbour.distance);

    constexpr float kSame = 1e-6F;
    const float reach = std::max(nearest.back().distance, 2 * kSame);
    InterpolationWeights result;
    result.count = InterpolationWeights::kMost;
    float sum = 0;
    for (std::size_t k = 0; k < result.count; ++k) {
        const float closeness = 1 / std::max(nearest[k].distance, kSame) - 1 / reach;
        result.index[k] = nearest[k].index;
        result.weight[k] = std::max(closeness, 0.0F) * std::max(closeness, 0.0F);
        sum += result.weight[k];
    }
    for (std::size_t k = 0; k < result.count; ++k) {
        result.weight[k] =
            sum > 0 ? result.weight[k] / sum : 1.0F / static_cast<float>(result.count);
    }
    return result;
}

std::vector<double> quadrature_weights(const Directions& directions) {
    // Each point of a Fibonacci lattice, which covers the sphere evenly, counts for its nearest
    // direction. The mirrored lattice is added so that weights of symmetric directions are equal;
    // of equally near directions the more lateral one counts, then the one in front, on both sides.
    constexpr std::size_t kPoints = 10000;
    std::vector<double> weights(directions.size());
    for (std::size_t p = 0; p < kPoints; ++p) {
        const double z = 1 - (2 * static_cast<double>(p) + 1) / static_cast<double>(kPoints);
        const double azimuth = kPi * (3 - std::sqrt(5.0)) * static_cast<double>(p);
        const double radius = std::sqrt(1 - z * z);
        for (const double side : {1.0, -1.0}) {
            const std::array<float, 3> point{static_cast<float>(radius * std::cos(azimuth)),
                                             static_cast<float>(side * radius * std::sin(azimuth)),
                                             static_cast<float>(z)};
            std::size_t nearest = 0;
            float best = -2;
            for (std::size_t i = 0; i < directions.size(); ++i) {
                const auto& d = directions[i];
                const float cosine = d[0] * point[0] + d[1] * point[1] + d[2] * point[2];
                const auto is_preferred = [&](const std::array<float, 3>& other) {
                    return std::pair(std::abs(d[1]), d[0]) >
                           std::pair(std::abs(other[1]), other[0]);
                };
                if (cosine > best || (cosine == best && is_preferred(directions[nearest]))) {
                    best = cosine;
                    nearest = i;
                }
            }
            weights[nearest] += 0.5 / static_cast<double>(kPoints);
        }
    }
    return weights;
}

std::vector<ClosingDirection> closing_directions(const Directions& directions,
                                                 const std::vector<double>& weights) {
    // The median is the share of the sphere of a direction away from gaps.
    std::vector<double> sorted = weights;
    const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
    std::nth_element(sorted.begin(), middle, sorted.end());
    const double covered_rad =
        std::max(std::acos(std::max(-1.0, 1 - 2 * kCovering * *middle)), kSpacing_rad / 2);

    std::vector<ClosingDirection> closing;
    for (const std::array<float, 3>& direction : candidate_directions()) {
        if (nearest_rad(directions, direction) <= covered_rad) continue;
        const auto left_turn = gap_end(directions, direction, 1, covered_rad);
        const auto right_turn = gap_end(directions, direction, -1, covered_rad);
        if (!left_turn || !right_turn) continue;
        const double gap_rad = left_turn->angle_rad + right_turn->angle_rad;
        ClosingDirection& added = closing.emplace_back();
        added.direction = direction;
        double sum = 0;
        const auto add = [&](const GapEnd& end, double share) {
            for (std::size_t k = 0; k < end.weights.count; ++k) {
                added.shares.emplace_back(end.weights.index[k],
                                          share * double{end.weights.weight[k]});
                sum += added.shares.back().second;
            }
        };
        add(*left_turn, right_turn->angle_rad / gap_rad);
        add(*right_turn, left_turn->angle_rad / gap_rad);
        for (auto& [index, share] : added.shares) share /= sum;  // rounding
    }
    return closing;
}

}  // namespace aula
