#include "engine/edges/shortest_path.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace aula {

namespace {

/// Bounds the time where edges touch. Elsewhere Newton's method converges quadratically.
constexpr int kMaxSteps = 40;

/// Derivative of the length at its minimum, a difference of cosines: 1e5 times their rounding.
constexpr double kExact = 1e-11;

/// Smooths the length of a segment between touching edges: far below tolerances::kInPlane_m.
constexpr double kRounding_m = 1e-7;

/// Least curvature of the length, where edges lie in the path: 1e-9 of that over an edge at 1 m.
constexpr double kRidge_per_m = 1e-9;

/// Length, gradient and Hessian at given points.
class Newton {
 public:
    Newton(const glm::dvec3& from, std::span<const DiffractionEdge* const> edges,
           const glm::dvec3& to)
        : from_(from), edges_(edges), to_(to) {
        const std::size_t n = edges.size();
        for (auto* values : {&slope_, &diagonal_, &above_, &step_}) values->resize(n);
    }

    double length_m(std::span<const double> along_m) const {
        double sum = 0;
        glm::dvec3 last = from_;
        for (std::size_t i = 0; i < edges_.size(); ++i) {
            const glm::dvec3 point = edges_[i]->point(along_m[i]);
            sum += rounded_m(point - last);
            last = point;
        }
        return sum + rounded_m(to_ - last);
    }

    /// Computes the step to the minimum. Returns false if the points are at it.
    bool prepare(std::span<const double> along_m) {
        const std::size_t n = edges_.size();
        std::fill(slope_.begin(), slope_.end(), 0.0);
        std::fill(diagonal_.begin(), diagonal_.end(), kRidge_per_m);
        std::fill(above_.begin(), above_.end(), 0.0);
        glm::dvec3 last = from_;
        for (std::size_t i = 0; i <= n; ++i) {
            const glm::dvec3 point = i < n ? edges_[i]->point(along_m[i]) : to_;
            const double length = rounded_m(point - last);
            const glm::dvec3 unit = (point - last) / length;
            const double before = i > 0 ? glm::dot(edges_[i - 1]->axis, unit) : 0;
            const double after = i < n ? glm::dot(edges_[i]->axis, unit) : 0;
            if (i > 0) {
                slope_[i - 1] -= before;
                diagonal_[i - 1] += (1 - before * before) / length;
            }
            if (i < n) {
                slope_[i] += after;
                diagonal_[i] += (1 - after * after) / length;
            }
            if (i > 0 && i < n) {
                const double turn = glm::dot(edges_[i - 1]->axis, edges_[i]->axis);
                above_[i - 1] = -(turn - before * after) / length;
            }
            last = point;
        }
        bool at_minimum = true;
        for (std::size_t i = 0; i < n; ++i) {
            const bool is_held = (along_m[i] <= 0 && slope_[i] > 0) ||
                                 (along_m[i] >= edges_[i]->length_m && slope_[i] < 0);
            if (is_held) {
                slope_[i] = 0;
                above_[i] = 0;
                if (i > 0) above_[i - 1] = 0;
            }
            at_minimum &= std::abs(slope_[i]) <= kExact;
        }
        if (!at_minimum) solve();
        return !at_minimum;
    }

    double step(std::size_t edge) const { return step_[edge]; }

 private:
    static double rounded_m(const glm::dvec3& d) {
        return std::sqrt(glm::dot(d, d) + kRounding_m * kRounding_m);
    }

    /// The tridiagonal system by elimination.
    void solve() {
        const std::size_t n = edges_.size();
        step_ = slope_;
        for (std::size_t i = 1; i < n; ++i) {
            const double share = above_[i - 1] / diagonal_[i - 1];
            diagonal_[i] = std::max(diagonal_[i] - share * above_[i - 1], kRidge_per_m);
            step_[i] -= share * step_[i - 1];
        }
        step_[n - 1] /= diagonal_[n - 1];
        for (std::size_t i = n - 1; i-- > 0;) {
            step_[i] = (step_[i] - above_[i] * step_[i + 1]) / diagonal_[i];
        }
    }

    glm::dvec3 from_;
    std::span<const DiffractionEdge* const> edges_;
    glm::dvec3 to_;
    std::vector<double> slope_;
    std::vector<double> diagonal_;
    std::vector<double> above_;  ///< [i] element (i, i + 1)
    std::vector<double> step_;
};

/// The point of an edge on the shortest path over it alone, also beyond its ends.
double unfolded_m(const DiffractionEdge& edge, const glm::dvec3& from, const glm::dvec3& to) {
    const WedgePoint a = edge.beside(from);
    const WedgePoint b = edge.beside(to);
    return a.radius_m + b.radius_m > 0 ? apex_m(a, b) : 0.5 * (a.along_m + b.along_m);
}

}  // namespace

ShortestPath shortest_path(const glm::dvec3& from, std::span<const DiffractionEdge* const> edges,
                           const glm::dvec3& to) {
    ShortestPath path;
    glm::dvec3 last = from;
    for (const DiffractionEdge* edge : edges) {
        path.along_m.push_back(std::clamp(unfolded_m(*edge, last, to), 0.0, edge->length_m));
        last = edge->point(path.along_m.back());
    }
    Newton newton(from, edges, to);
    path.length_m = newton.length_m(path.along_m);
    if (edges.size() < 2) return path;
    std::vector<double> next(edges.size());
    for (int i = 0; i < kMaxSteps && newton.prepare(path.along_m); ++i) {
        bool is_shorter = false;
        for (double share = 1; share > 1e-9 && !is_shorter; share /= 2) {
            for (std::size_t e = 0; e < edges.size(); ++e) {
                next[e] =
                    std::clamp(path.along_m[e] - share * newton.step(e), 0.0, edges[e]->length_m);
            }
            const double length_m = newton.length_m(next);
            if (length_m < path.length_m) {
                path.length_m = length_m;
                path.along_m.swap(next);
                is_shorter = true;
            }
        }
        if (!is_shorter) break;
    }
    return path;
}

}  // namespace aula
