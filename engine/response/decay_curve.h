#pragma once

#include <numbers>
#include <optional>
#include <vector>

#include "aula/engine/room_acoustics.h"

namespace aula {

/// Strength is the fluence times this. The reference is the free field at 10 m.
inline constexpr double kStrength_m2 = 400 * std::numbers::pi;

/// Energy over time of one band, from time zero on.
struct SampledDecay {
    std::vector<double> energy;  ///< [bin] without noise
    double bin_s = 0;            ///< width of a bin
    /// What follows the last bin; empty: it is estimated from the late slope.
    struct Tail {
        double energy = 0;
        double time_s = 0;  ///< mean time after the last bin: its time constant
    };
    std::optional<Tail> tail;

    double length_s() const { return static_cast<double>(energy.size()) * bin_s; }
};

/// Schroeder's backward integral of one band from time zero on, piecewise linear (a discrete
/// arrival is two points at one time), with an extrapolated tail.
class DecayCurve {
 public:
    DecayCurve(const EnergyResponse& response, double zero_s, std::size_t band);
    explicit DecayCurve(const SampledDecay& decay);

    /// Energy of the response.
    double total() const { return total_; }

    /// Energy from a time on, to the end of the response.
    double from(double time_s) const;

    /// Estimated energy after the end of the response.
    double tail() const { return tail_; }

    /// Time at which the curve, including the tail, first falls to `level_db` < 0 re its start.
    /// Empty if it never does or does so with its last arrival.
    std::optional<double> time_at(double level_db) const;

    /// Slope in dB/s of a least-squares line through the curve, including the tail, between two
    /// times; empty if it is not distinguishable from no decay.
    std::optional<double> slope_db_s(double begin_s, double end_s) const;

    /// Centre time including the tail.
    double centre_s() const;

 private:
    /// Takes the energy between each point and the one before; sums it from the end.
    void integrate();
    void extrapolate();

    struct Point {
        double time_s, energy;
    };
    std::vector<Point> points_;
    double total_ = 0;
    double tail_ = 0;
    double tail_time_s_ = 0;
};

/// The parameters of ISO 3382-1 of a decay curve, by the rules of room_parameters().
BandParameters band_parameters(const DecayCurve& curve);

}  // namespace aula
