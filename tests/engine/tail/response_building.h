#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "aula/engine/impulse_response.h"
#include "engine/tail/noise_carriers.h"

namespace aula::test {

inline constexpr double kRate_hz = 48000;
/// Does not attenuate sound: third octaves differ by surfaces only.
inline constexpr Medium kNoAir{.air_absorption = false};

inline constexpr double kFourPi = 4 * std::numbers::pi;

/// Diffuse, energy per second e0 exp(-13.8155 t / T) from `begin_s` on.
inline EnergyResponse decay(double length_s, const std::array<double, kBandCount>& time_s,
                            const std::array<double, kBandCount>& start, double begin_s = 0) {
    EnergyResponse r = EnergyResponse::silent(TimeBins(length_s));
    for (std::size_t i = r.bins.index(begin_s); i < r.bins.count(); ++i) {
        for (std::size_t b = 0; b < kBandCount; ++b) {
            const double k = 6 * std::log(10.0) / time_s[b];
            const double left = std::exp(-k * (r.bins.begin_s(i) - begin_s));
            const double right = std::exp(-k * (r.bins.end_s(i) - begin_s));
            r.energy[i][b] = static_cast<float>(start[b] / k * (left - right));
        }
    }
    return r;
}

constexpr std::array<double, kBandCount> all(double x) { return {x, x, x, x, x, x, x, x}; }

inline double energy_of(const std::vector<float>& samples) {
    double sum = 0;
    for (const float x : samples) sum += double{x} * double{x};
    return sum;
}

/// The carriers of a seed, made once.
inline std::shared_ptr<const NoiseCarriers> carriers(std::uint64_t seed) {
    static std::map<std::uint64_t, std::shared_ptr<const NoiseCarriers>> made;
    auto& carriers = made[seed];
    if (!carriers) carriers = make_noise_carriers(kRate_hz, seed);
    return carriers;
}

inline ImpulseResponse build(const EnergyResponse& energy, double length_s, std::uint64_t seed = 1,
                             const std::string& source = "source") {
    ImpulseResponse ir;
    ImpulseResponseBuilder(carriers(seed), kNoAir, length_s, source).build(energy, ir);
    return ir;
}

inline double db(double ratio) { return 10 * std::log10(ratio); }

}  // namespace aula::test
