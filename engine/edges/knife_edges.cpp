#include "engine/edges/knife_edges.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <iterator>
#include <numbers>
#include <vector>

namespace aula {

namespace {

/// Of the rule of Gauss and Legendre at an edge: exact within 1e-4 (test_engine "N knife edges*").
constexpr std::size_t kNodes = 20;
using Values = std::array<double, kNodes>;
using ComplexValues = std::array<std::complex<double>, kNodes>;

struct Nodes {
    Values place;  ///< ascending, 0 to 1
    Values weight;
};

/// The Gauss-Legendre rule.
Nodes gauss_legendre() {
    Nodes nodes;
    for (std::size_t i = 0; i < kNodes; ++i) {
        double x = -std::cos(std::numbers::pi * (static_cast<double>(i) + 0.75) / (kNodes + 0.5));
        double slope = 1;
        for (int step = 0; step < 8; ++step) {
            double last = 1;
            double value = x;
            for (std::size_t n = 2; n <= kNodes; ++n) {
                const auto order = static_cast<double>(n);
                const double next = ((2 * order - 1) * x * value - (order - 1) * last) / order;
                last = value;
                value = next;
            }
            slope = static_cast<double>(kNodes) * (x * value - last) / (x * x - 1);
            x -= value / slope;
        }
        nodes.place[i] = 0.5 * (1 + x);
        nodes.weight[i] = 1 / ((1 - x * x) * slope * slope);
    }
    return nodes;
}

/// The nodes resolve the kernels of longer segments, relative to the variance of the heights
/// (test_engine "of edges that are too close*").
constexpr double kShortest = 0.035;

// Edges whose detour is longer, in radians, act independently of the others: alone they change the
// pressure by 1 / (2 sqrt(pi detour)), 10 % and 6 %. A low edge is integrated below itself, where
// the integrand decays, and may therefore be farther away (test_engine "over high and low edges*").
constexpr double kLongestDetour_rad = 8;
constexpr double kLongestLowDetour_rad = 20;

// The logarithms of the growth above which an edge is low, and that two low edges may have: the
// nodes resolve a growth by exp(0.25), and by exp(4) their sum loses less than two digits (same
// test).
constexpr double kLow = 0.25;
constexpr double kMostGrowth = 4;

/// Edges of the integral, and the detour over each, relative to the straight line between those
/// around which the path bends.
struct Placed {
    KnifeEdge edge;
    double detour_m = 0;
};

/// Joins edges that are too close together to be told apart.
std::vector<Placed> place(std::span<const KnifeEdge> edges, double length_m) {
    std::vector<Placed> placed;
    for (const KnifeEdge& edge : edges) {
        if (!placed.empty()) {
            KnifeEdge& last = placed.back().edge;
            const double middle_m = 0.5 * (last.at_m + edge.at_m);
            if (edge.at_m - last.at_m < kShortest * middle_m * (1 - middle_m / length_m)) {
                last = {middle_m, last.turn_rad + edge.turn_rad,
                        std::min(last.clearance_m, edge.clearance_m)};
                continue;
            }
        }
        placed.push_back({edge});
    }
    const auto bends = [](const Placed& p) { return p.edge.turn_rad > 0; };
    for (auto p = placed.begin(); p != placed.end(); ++p) {
        const auto last = std::find_if(std::reverse_iterator(p), placed.rend(), bends);
        const auto next = std::find_if(p + 1, placed.end(), bends);
        const double before_m = p->edge.at_m - (last == placed.rend() ? 0 : last->edge.at_m);
        const double after_m = (next == placed.end() ? length_m : next->edge.at_m) - p->edge.at_m;
        p->detour_m =
            0.5 * p->edge.clearance_m * p->edge.clearance_m * (1 / before_m + 1 / after_m);
    }
    return placed;
}

/// The pressure over one edge far below a path, relative to free field, by the asymptotic series of
/// the Fresnel integral.
std::complex<double> far_above(double detour_rad) {
    const std::complex<double> z = std::polar(std::sqrt(detour_rad), std::numbers::pi / 4);
    const std::complex<double> square(0, detour_rad);
    return 1.0 - 0.5 * std::exp(-square) / (z * std::sqrt(std::numbers::pi)) * (1.0 - 0.5 / square);
}

/// The integrand above the lower of two edges grows by the exponential of this.
double growth(const KnifeEdge& a, const KnifeEdge& b, double wave_number_per_m) {
    const double step_m = b.clearance_m - a.clearance_m;
    return wave_number_per_m * step_m * step_m / (4 * (b.at_m - a.at_m));
}

/// The edges of the integral for a band, and the field over the others, by which it is multiplied.
class BandEdges {
 public:
    struct Edge {
        const Placed* placed = nullptr;
        bool is_low = false;  ///< far below an edge beside it; see Heights
    };

    BandEdges(std::span<const Placed> placed, double wave_number_per_m) : k_(wave_number_per_m) {
        for (const Placed& p : placed) {
            if (k_ * p.detour_m > kLongestLowDetour_rad) {
                leave_out(p);
            } else {
                add(p);
            }
        }
        std::erase_if(edges_, [&](const Edge& edge) {
            const bool is_far = !edge.is_low && k_ * edge.placed->detour_m > kLongestDetour_rad;
            if (is_far) leave_out(*edge.placed);
            return is_far;
        });
    }

    const std::vector<Edge>& edges() const { return edges_; }
    std::complex<double> others() const { return others_; }

    /// The slope from an edge to the steepest edge beside it.
    double slope(std::size_t edge) const {
        const KnifeEdge& at = edges_[edge].placed->edge;
        double steepest = 0;
        const auto to = [&](const KnifeEdge& other) {
            steepest = std::max(
                steepest, std::abs((other.clearance_m - at.clearance_m) / (other.at_m - at.at_m)));
        };
        if (edge > 0) to(edges_[edge - 1].placed->edge);
        if (edge + 1 < edges_.size()) to(edges_[edge + 1].placed->edge);
        return steepest;
    }

 private:
    void leave_out(const Placed& p) { others_ *= far_above(k_ * p.detour_m); }

    double growth_between(const Edge& a, const Edge& b) const {
        return growth(a.placed->edge, b.placed->edge, k_);
    }

    /// Whether an edge can be low: no low one beside it has a very different height.
    bool can_be_low(std::vector<Edge>::const_iterator edge) const {
        const bool above = edge != edges_.begin() && std::prev(edge)->is_low &&
                           growth_between(*std::prev(edge), *edge) > kMostGrowth;
        const bool below = std::next(edge) != edges_.end() && std::next(edge)->is_low &&
                           growth_between(*edge, *std::next(edge)) > kMostGrowth;
        return !above && !below;
    }

    void add(const Placed& p) {
        Edge next{&p, false};
        while (!next.is_low) {
            const auto found = std::find_if(edges_.rbegin(), edges_.rend(),
                                            [](const Edge& edge) { return !edge.is_low; });
            if (found == edges_.rend()) break;
            const auto last = std::prev(found.base());
            const double last_growth = growth_between(*last, next);
            if (last_growth < kLow) break;
            if (p.edge.clearance_m > last->placed->edge.clearance_m) {
                next.is_low = true;
            } else if (can_be_low(last)) {
                last->is_low = true;
            } else if (last_growth < kMostGrowth) {
                break;
            } else {
                leave_out(*last->placed);
                edges_.erase(last);
            }
        }
        // Of two low edges of very different heights beside each other the lower one is left out.
        if (!edges_.empty() && edges_.back().is_low &&
            growth_between(edges_.back(), next) > kMostGrowth) {
            if (p.edge.clearance_m > edges_.back().placed->edge.clearance_m) {
                leave_out(p);
                return;
            }
            if (next.is_low) {
                leave_out(*edges_.back().placed);
                edges_.pop_back();
            }
        }
        edges_.push_back(next);
    }

    double k_;
    std::vector<Edge> edges_;
    std::complex<double> others_ = 1;
};

/// The integral over the heights at edges, along exp(-i pi / 4) from each edge, where the integrand
/// does not oscillate: x_i = -clearance_i + exp(-i pi / 4) s_i. The kernels are then Gaussian in s,
/// times factors of single s. Between edges of different clearances these factors grow along the
/// heights above the lower edge and decay along those below it, x_i = -clearance_i -
/// exp(-i pi / 4) s_i. The field over a low edge is therefore the one without it, minus the part
/// below it.
class Heights {
 public:
    Heights(double wave_number_per_m, double length_m)
        : k_(wave_number_per_m), length_m_(length_m) {
        fields_.push_back({});
        fields_.back().values[0] = 1;
    }

    /// Continues the field over the next edge. `slope`: to the edges beside a low one.
    void pass(const KnifeEdge& edge, bool is_low, double slope) {
        const double width_m = std::sqrt(edge.at_m * (length_m_ - edge.at_m) / (length_m_ * k_));
        const double unit_m =
            1 / (1 / (5.5 * width_m + 0.8 * edge.clearance_m) + k_ * (edge.turn_rad + slope) / 14);
        FieldAtEdge field{.at_m = edge.at_m, .clearance_m = edge.clearance_m, .count = kNodes};
        const double sign = is_low ? -1 : 1;
        for (std::size_t n = 0; n < kNodes; ++n) field.s_m[n] = sign * unit_m * kRule.place[n];
        const std::complex<double> turn = kI * k_ * edge.turn_rad;
        const ComplexValues arrived = arrive(edge.at_m, edge.clearance_m, field.s_m);
        for (std::size_t n = 0; n < kNodes; ++n) {
            const std::complex<double> x = kTurned * field.s_m[n] - edge.clearance_m;
            field.values[n] = sign * arrived[n] * unit_m * kRule.weight[n] * std::exp(-turn * x);
        }
        if (!is_low) fields_.clear();
        fields_.push_back(field);
    }

    /// The field at the end relative to free field.
    std::complex<double> at_end() const {
        return arrive(length_m_, 0, {})[0] / std::sqrt(k_ / (2 * std::numbers::pi * length_m_));
    }

 private:
    /// The field at an edge; at the source it has a single height.
    struct FieldAtEdge {
        double at_m = 0;
        double clearance_m = 0;
        std::size_t count = 1;
        Values s_m{};
        ComplexValues values{};
    };

    /// The field from the last edge that is not low, and from all low ones after it.
    ComplexValues arrive(double at_m, double clearance_m, const Values& s_m) const {
        ComplexValues arrived{};
        for (const FieldAtEdge& from : fields_) add_arrival(from, at_m, clearance_m, s_m, arrived);
        return arrived;
    }

    void add_arrival(const FieldAtEdge& from, double at_m, double clearance_m, const Values& s_m,
                     ComplexValues& arrived) const {
        const double segment_m = at_m - from.at_m;
        const double step_m = clearance_m - from.clearance_m;
        const double gauss_per_m2 = k_ / (2 * segment_m);
        const std::complex<double> tilt = 2 * gauss_per_m2 * step_m * kI * kTurned;
        const std::complex<double> whole = std::sqrt(gauss_per_m2 / std::numbers::pi) *
                                           std::exp(-kI * gauss_per_m2 * step_m * step_m);
        ComplexValues before;
        for (std::size_t m = 0; m < from.count; ++m) {
            before[m] = from.values[m] * std::exp(-tilt * from.s_m[m]);
        }
        for (std::size_t n = 0; n < kNodes; ++n) {
            std::complex<double> sum = 0;
            for (std::size_t m = 0; m < from.count; ++m) {
                const double away_m = s_m[n] - from.s_m[m];
                sum += before[m] * std::exp(-gauss_per_m2 * away_m * away_m);
            }
            arrived[n] += whole * sum * std::exp(tilt * s_m[n]);
        }
    }

    static inline const Nodes kRule = gauss_legendre();
    static constexpr std::complex<double> kI{0, 1};
    static constexpr std::complex<double> kTurned{1 / std::numbers::sqrt2,
                                                  -1 / std::numbers::sqrt2};

    double k_;
    double length_m_;
    std::vector<FieldAtEdge> fields_;
};

}  // namespace

/// With heights x_i above the straight path, x_0 = x_(N+1) = 0, and segments d_i, the pressure is
///
///     int prod_i sqrt(ik / (2 pi d_i)) exp(-ik (x_i - x_(i-1))^2 / (2 d_i)) exp(-ik turn_i x_i) dx
///
/// over x_i > -clearance_i, relative to that over all heights without turns.
ComplexBands knife_edges(std::span<const KnifeEdge> edges, double length_m,
                         const WedgeIntegral& integral) {
    const std::vector<Placed> placed = place(edges, length_m);
    ComplexBands relative;
    for (std::size_t b = 0; b < kBandCount; ++b) {
        const double k = integral.wave_number_per_m(b);
        Heights heights(k, length_m);
        const BandEdges near(placed, k);
        for (std::size_t i = 0; i < near.edges().size(); ++i) {
            const auto& [p, is_low] = near.edges()[i];
            heights.pass(p->edge, is_low, is_low ? near.slope(i) : 0);
        }
        relative[b] = near.others() * heights.at_end();
    }
    return relative;
}

}  // namespace aula
