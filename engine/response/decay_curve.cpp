#include "engine/response/decay_curve.h"

#include <algorithm>
#include <cmath>

namespace aula {

namespace {

double db(double ratio) { return 10 * std::log10(ratio); }

/// A level that changes by less than this per quarter of the response does not decay.
constexpr double kLeastFall_db = -0.5;

std::optional<double> finite(double x) {
    return std::isfinite(x) ? std::optional<double>(x) : std::nullopt;
}

/// Whether the tail is 10 dB below a level of the decay curve.
bool is_clear(const DecayCurve& curve, double level_db) {
    return curve.tail() <= (curve.total() + curve.tail()) * std::pow(10, (level_db - 10) / 10);
}

/// Reverberation time from a least-squares line through the decay curve between two levels. The
/// curve includes the tail (ISO 3382-1, 5.3.3).
std::optional<double> decay_time_s(const DecayCurve& curve, double from_db, double to_db) {
    if (!is_clear(curve, to_db)) return std::nullopt;
    const std::optional<double> begin_s = from_db < 0 ? curve.time_at(from_db) : 0.0;
    const std::optional<double> end_s = curve.time_at(to_db);
    if (!begin_s || !end_s || !(*end_s > *begin_s)) return std::nullopt;
    const auto slope_db_s = curve.slope_db_s(*begin_s, *end_s);
    return slope_db_s ? finite(-60 / *slope_db_s) : std::nullopt;
}

}  // namespace

DecayCurve::DecayCurve(const EnergyResponse& response, double zero_s, std::size_t band) {
    const auto add = [&](double time_s, double energy) {
        points_.push_back({std::max(time_s - zero_s, 0.0), energy});
    };
    auto path = response.paths.begin();
    for (std::size_t i = 0; i < response.bins.count(); ++i) {
        double from_s = response.bins.begin_s(i);
        const double end_s = response.bins.end_s(i);
        const double power = double{response.energy[i][band]} / (end_s - from_s);
        add(from_s, 0);
        for (; path != response.paths.end() && response.arrival_s(*path) < end_s; ++path) {
            const double arrival_s = response.arrival_s(*path);
            add(arrival_s, power * (arrival_s - from_s));
            add(arrival_s, double{path->energy[band]});
            from_s = arrival_s;
        }
        add(end_s, power * (end_s - from_s));
    }
    integrate();
    extrapolate();
}

DecayCurve::DecayCurve(const SampledDecay& decay) {
    points_.push_back({0, 0});
    for (std::size_t i = 0; i < decay.energy.size(); ++i)
        points_.push_back({static_cast<double>(i + 1) * decay.bin_s, decay.energy[i]});
    integrate();
    if (decay.tail) {
        tail_ = decay.tail->energy;
        tail_time_s_ = decay.tail->time_s;
    } else {
        extrapolate();
    }
}

void DecayCurve::integrate() {
    for (auto p = points_.rbegin(); p != points_.rend(); ++p) {
        const double arrives = p->energy;
        p->energy = total_;
        total_ += arrives;
    }
}

double DecayCurve::from(double time_s) const {
    const auto p = std::lower_bound(points_.begin(), points_.end(), time_s,
                                    [](const Point& point, double t) { return point.time_s < t; });
    if (p == points_.begin()) return total_;
    if (p == points_.end()) return 0;
    const Point& left = *(p - 1);
    return left.energy +
           (p->energy - left.energy) * (time_s - left.time_s) / (p->time_s - left.time_s);
}

std::optional<double> DecayCurve::time_at(double level_db) const {
    const double energy = (total_ + tail_) * std::pow(10, level_db / 10) - tail_;
    double before = total_;
    double before_s = 0;
    for (const Point& p : points_) {
        if (p.energy <= energy) {
            if (p.energy <= 0) return std::nullopt;
            if (p.energy == before) return p.time_s;
            return before_s + (p.time_s - before_s) * (before - energy) / (before - p.energy);
        }
        before = p.energy;
        before_s = p.time_s;
    }
    return std::nullopt;
}

std::optional<double> DecayCurve::slope_db_s(double begin_s, double end_s) const {
    constexpr int kSamples = 400;  // of the 30 dB of T30, 0.075 dB each
    double covariance = 0;
    double variance = 0;
    for (int i = 0; i < kSamples; ++i) {
        const double t = (i + 0.5) / kSamples - 0.5;  // mean 0
        const double time_s = begin_s + (end_s - begin_s) * (t + 0.5);
        covariance += t * db(from(time_s) + tail_);
        variance += t * t;
    }
    const double slope = covariance / variance / (end_s - begin_s);
    // Where a faint arrival long precedes the others, the curve stays at 0 dB and then falls at
    // once.
    if (points_.empty() || !(slope * points_.back().time_s <= 4 * kLeastFall_db))
        return std::nullopt;
    return slope;
}

double DecayCurve::centre_s() const {
    // The mean of t is the integral of the backward integral divided by the total.
    double area = tail_ * (points_.back().time_s + tail_time_s_);
    for (std::size_t i = 1; i < points_.size(); ++i) {
        area += 0.5 * (points_[i].energy + points_[i - 1].energy) *
                (points_[i].time_s - points_[i - 1].time_s);
    }
    return area / (total_ + tail_);
}

// The energies e1 and e2 of the last two quarters of the response give the late slope: with
// r = e2 / e1 the quarters after the end have e2 r + e2 r^2 + .. = e2 r / (1 - r).
void DecayCurve::extrapolate() {
    if (points_.empty()) return;
    const double end_s = points_.back().time_s;
    const double e2 = from(0.75 * end_s);
    if (!(e2 > 0)) return;
    const double e1 = from(0.5 * end_s) - e2;
    const double greatest = std::pow(10, kLeastFall_db / 10);
    const double r = e1 > 0 ? std::min(e2 / e1, greatest) : greatest;
    tail_ = e2 * r / (1 - r);
    tail_time_s_ = 0.25 * end_s / -std::log(r);
}

BandParameters band_parameters(const DecayCurve& curve) {
    BandParameters p;
    if (!(curve.total() > 0)) return p;
    p.t20_s = decay_time_s(curve, -5, -25);
    p.t30_s = decay_time_s(curve, -5, -35);
    p.edt_s = decay_time_s(curve, 0, -10);
    if (!is_clear(curve, 0)) return p;
    const double total = curve.total() + curve.tail();
    const auto clarity_db = [&](double limit_s) {
        const double late = curve.from(limit_s) + curve.tail();
        return finite(db((total - late) / late));
    };
    p.c50_db = clarity_db(0.05);
    p.c80_db = clarity_db(0.08);
    p.d50 = finite(1 - (curve.from(0.05) + curve.tail()) / total);
    p.ts_s = finite(curve.centre_s());
    p.g_db = finite(db(total * kStrength_m2));
    return p;
}

}  // namespace aula
