#include "aula/engine/room_acoustics.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>
#include <vector>

#include "engine/response/time_zero.h"

namespace aula {
namespace {

double db(double ratio) { return 10 * std::log10(ratio); }

/// Strength is the fluence times this. The reference is the free field at 10 m.
constexpr double kStrength_m2 = 400 * std::numbers::pi;

std::optional<double> finite(double x) {
    return std::isfinite(x) ? std::optional<double>(x) : std::nullopt;
}

/// Schroeder's backward integral of one band from time zero on, piecewise linear (a discrete
/// arrival is two points at one time), with an extrapolated tail.
class DecayCurve {
 public:
    DecayCurve(const EnergyResponse& response, double zero_s, std::size_t band) {
        // First the energy between each point and the one before.
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
        // Then the energy after each point, summed from the end.
        for (auto p = points_.rbegin(); p != points_.rend(); ++p) {
            const double arrives = p->energy;
            p->energy = total_;
            total_ += arrives;
        }
        extrapolate();
    }

    /// Energy of the response.
    double total() const { return total_; }

    /// Energy from a time on, to the end of the response.
    double from(double time_s) const {
        const auto p =
            std::lower_bound(points_.begin(), points_.end(), time_s,
                             [](const Point& point, double t) { return point.time_s < t; });
        if (p == points_.begin()) return total_;
        if (p == points_.end()) return 0;
        const Point& left = *(p - 1);
        return left.energy +
               (p->energy - left.energy) * (time_s - left.time_s) / (p->time_s - left.time_s);
    }

    /// Estimated energy after the end of the response.
    double tail() const { return tail_; }

    /// Whether a decay by that slope is distinguishable from no decay.
    bool resolves(double slope_db_s) const {
        return !points_.empty() && slope_db_s * points_.back().time_s <= 4 * kLeastFall_db;
    }

    /// Time at which the curve, including the tail, first falls to `level_db` < 0 re its start.
    /// Empty if it never does or does so with its last arrival.
    std::optional<double> time_at(double level_db) const {
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

    /// Centre time including the tail.
    double centre_s() const {
        // The mean of t is the integral of the backward integral divided by the total.
        double area = tail_ * (points_.back().time_s + tail_time_s_);
        for (std::size_t i = 1; i < points_.size(); ++i) {
            area += 0.5 * (points_[i].energy + points_[i - 1].energy) *
                    (points_[i].time_s - points_[i - 1].time_s);
        }
        return area / (total_ + tail_);
    }

 private:
    // The energies e1 and e2 of the last two quarters of the response give the late slope: with
    // r = e2 / e1 the quarters after the end have e2 r + e2 r^2 + .. = e2 r / (1 - r).
    void extrapolate() {
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

    /// A level that changes by less than this per quarter of the response does not decay.
    static constexpr double kLeastFall_db = -0.5;

    struct Point {
        double time_s, energy;
    };
    std::vector<Point> points_;
    double total_ = 0;
    double tail_ = 0;
    double tail_time_s_ = 0;  ///< mean time of the tail after the end
};

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
    constexpr int kSamples = 400;
    double covariance = 0;
    double variance = 0;
    for (int i = 0; i < kSamples; ++i) {
        const double t = (i + 0.5) / kSamples - 0.5;  // mean 0
        const double time_s = *begin_s + (*end_s - *begin_s) * (t + 0.5);
        covariance += t * db(curve.from(time_s) + curve.tail());
        variance += t * t;
    }
    const double slope_db_s = covariance / variance / (*end_s - *begin_s);
    // Where a faint arrival long precedes the others, the curve stays at 0 dB and then falls at
    // once.
    if (!curve.resolves(slope_db_s)) return std::nullopt;
    return finite(-60 / slope_db_s);
}

BandParameters parameters(const DecayCurve& curve) {
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

/// Time in s in which a diffuse field decays by 60 dB, for each band: energy falls as
/// exp(-(m + w) c t) with the losses m of the air and w = `walls_per_m` of the walls.
template <typename Walls>
Bands decay_time_s(const Bands& attenuation_per_m, double speed_of_sound_m_s,
                   const Walls& walls_per_m) {
    Bands time_s;
    for (std::size_t b = 0; b < kBandCount; ++b) {
        const double loss_per_m = double{attenuation_per_m[b]} + walls_per_m(b);
        time_s[b] = static_cast<float>(6 * std::log(10.0) / (speed_of_sound_m_s * loss_per_m));
    }
    return time_s;
}

}  // namespace

double time_zero_s(const EnergyResponse& response) {
    double first_path_s = response.bins.length_s();
    for (const SpecularPath& p : response.paths) {
        const double arrival_s = response.arrival_s(p);
        if (arrival_s >= response.bins.length_s()) continue;
        if (p.order == 0) return arrival_s;
        first_path_s = std::min(first_path_s, arrival_s);
    }
    for (std::size_t i = 0; i < response.bins.count(); ++i) {
        if (first_path_s < response.bins.end_s(i)) return first_path_s;
        if (response.energy[i].max() > 0) return response.bins.begin_s(i);
    }
    return first_path_s;
}

RoomParameters room_parameters(const EnergyResponse& response) {
    const double zero_s = time_zero_s(response);
    RoomParameters result;
    for (std::size_t b = 0; b < kBandCount; ++b) {
        result[b] = parameters(DecayCurve(response, zero_s, b));
    }
    return result;
}

bool is_audible(const EnergyResponse& response) {
    const double min = std::pow(10, kAudible_g_db / 10) / kStrength_m2;
    for (std::size_t b = 0; b < kBandCount; ++b) {
        if (response.total(b) >= min) return true;
    }
    return false;
}

Bands sabine_time_s(double mean_free_path_m, const Bands& mean_absorption,
                    const Bands& attenuation_per_m, double speed_of_sound_m_s) {
    return decay_time_s(attenuation_per_m, speed_of_sound_m_s, [&](std::size_t band) {
        return double{mean_absorption[band]} / mean_free_path_m;
    });
}

Bands eyring_time_s(double mean_free_path_m, const Bands& mean_absorption,
                    const Bands& attenuation_per_m, double speed_of_sound_m_s) {
    return decay_time_s(attenuation_per_m, speed_of_sound_m_s, [&](std::size_t band) {
        return -std::log1p(-double{mean_absorption[band]}) / mean_free_path_m;
    });
}

}  // namespace aula
