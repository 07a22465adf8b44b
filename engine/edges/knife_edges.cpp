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

constexpr double kPi = std::numbers::pi;
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
        double x = -std::cos(kPi * (static_cast<double>(i) + 0.75) / (kNodes + 0.5));
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

// The nodes resolve the kernels of longer segments, relative to the variance of the heights.
constexpr double kShortest = 0.035;

// Edges whose detour is longer, in radians, act independently of the others.
constexpr double kLongestDetour_rad = 8;

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
    const std::complex<double> z = std::polar(std::sqrt(detour_rad), kPi / 4);
    const std::complex<double> square(0, detour_rad);
    return 1.0 - 0.5 * std::exp(-square) / (z * std::sqrt(kPi)) * (1.0 - 0.5 / square);
}

/// Whether the integrand grows by more than exp(4) between two edges.
bool grows(const Placed& a, const Placed& b, double wave_number_per_m) {
    const double step_m = b.edge.clearance_m - a.edge.clearance_m;
    const double segment_m = b.edge.at_m - a.edge.at_m;
    return wave_number_per_m * step_m * step_m / (4 * segment_m) > 4 &&
           wave_number_per_m * std::max(a.detour_m, b.detour_m) > 1;
}

/// The integral over the heights above edges, along exp(-i pi / 4) from each edge, where the
/// integrand does not oscillate: x_i = -clearance_i + exp(-i pi / 4) s_i. The kernels are then
/// Gaussian in s, times factors of single s.
class Heights {
 public:
    Heights(double wave_number_per_m, double length_m)
        : k_(wave_number_per_m), length_m_(length_m) {}

    /// Continues the field over the next edge.
    void pass(const KnifeEdge& edge) {
        const double width_m = std::sqrt(edge.at_m * (length_m_ - edge.at_m) / (length_m_ * k_));
        const double unit_m =
            1 / (1 / (5.5 * width_m + 0.8 * edge.clearance_m) + k_ * edge.turn_rad / 14);
        std::array<double, kNodes> s_m;
        for (std::size_t n = 0; n < kNodes; ++n) s_m[n] = unit_m * kRule.place[n];
        const std::complex<double> turn = kI * k_ * edge.turn_rad;
        const ComplexValues arrived = arrive(edge.at_m, edge.clearance_m, s_m);
        for (std::size_t n = 0; n < kNodes; ++n) {
            const std::complex<double> x = kTurned * s_m[n] - edge.clearance_m;
            field_[n] = arrived[n] * unit_m * kRule.weight[n] * std::exp(-turn * x);
        }
        s_m_ = s_m;
        at_m_ = edge.at_m;
        clearance_m_ = edge.clearance_m;
    }

    /// The field at the end relative to free field.
    std::complex<double> at_end() const {
        if (at_m_ == 0) return 1;
        return arrive(length_m_, 0, {})[0] / std::sqrt(k_ / (2 * kPi * length_m_));
    }

 private:
    ComplexValues arrive(double at_m, double clearance_m, const Values& s_m) const {
        const double segment_m = at_m - at_m_;
        const double step_m = clearance_m - clearance_m_;
        const double gauss_per_m2 = k_ / (2 * segment_m);
        const std::complex<double> tilt = 2 * gauss_per_m2 * step_m * kI * kTurned;
        const std::complex<double> whole =
            std::sqrt(gauss_per_m2 / kPi) * std::exp(-kI * gauss_per_m2 * step_m * step_m);
        ComplexValues before;
        for (std::size_t n = 0; n < kNodes; ++n) before[n] = field_[n] * std::exp(-tilt * s_m_[n]);
        ComplexValues arrived;
        for (std::size_t n = 0; n < kNodes; ++n) {
            std::complex<double> sum = 0;
            for (std::size_t m = 0; m < (at_m_ > 0 ? kNodes : 1); ++m) {
                const double away_m = s_m[n] - s_m_[m];
                sum += before[m] * std::exp(-gauss_per_m2 * away_m * away_m);
            }
            arrived[n] = whole * sum * std::exp(tilt * s_m[n]);
        }
        return arrived;
    }

    static inline const Nodes kRule = gauss_legendre();
    static constexpr std::complex<double> kI{0, 1};
    static constexpr std::complex<double> kTurned{1 / std::numbers::sqrt2,
                                                  -1 / std::numbers::sqrt2};

    double k_;
    double length_m_;
    double at_m_ = 0;  ///< of the last edge
    double clearance_m_ = 0;
    Values s_m_{};
    ComplexValues field_{1};  ///< at the first edge: from the source alone
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
        std::complex<double> far = 1;
        // Between edges of different clearances the integrand grows: the lower edge is left out.
        std::vector<const Placed*> near;
        for (const Placed& p : placed) {
            const Placed* next = &p;
            while (next != nullptr && !near.empty() && grows(*near.back(), *next, k)) {
                const bool is_lower = next->detour_m > near.back()->detour_m;
                far *= far_above(k * (is_lower ? next : near.back())->detour_m);
                if (is_lower) {
                    next = nullptr;
                } else {
                    near.pop_back();
                }
            }
            if (next != nullptr && k * next->detour_m > kLongestDetour_rad) {
                far *= far_above(k * next->detour_m);
            } else if (next != nullptr) {
                near.push_back(next);
            }
        }
        for (const Placed* p : near) heights.pass(p->edge);
        relative[b] = far * heights.at_end();
    }
    return relative;
}

}  // namespace aula
