#include "audio/dsp/fractional_delay.h"

#include <cmath>
#include <numbers>

#include "audio/base/aligned.h"

namespace aula {

namespace {

// Shape parameter of the Kaiser window for 90 dB.
constexpr double kBeta = 9;

double windowed_sinc(double x) {
    const double half = static_cast<double>(kInterpolationTaps) / 2;
    if (std::abs(x) >= half) return 0;
    if (x == std::round(x)) return x == 0 ? 1 : 0;
    const double window = std::cyl_bessel_i(0.0, kBeta * std::sqrt(1 - x * x / (half * half))) /
                          std::cyl_bessel_i(0.0, kBeta);
    return window * std::sin(std::numbers::pi * x) / (std::numbers::pi * x);
}

float tap(std::size_t k, double fraction) {
    return static_cast<float>(windowed_sinc(
        static_cast<double>(k) - static_cast<double>(FractionalDelay::kBefore) - fraction));
}

/// [phase 0 to `phases`][tap]
AlignedVector<float> make_table(std::size_t phases) {
    AlignedVector<float> table;
    table.reserve((phases + 1) * kInterpolationTaps);
    for (std::size_t phase = 0; phase <= phases; ++phase) {
        for (std::size_t k = 0; k < kInterpolationTaps; ++k)
            table.push_back(tap(k, static_cast<double>(phase) / static_cast<double>(phases)));
    }
    return table;
}

}  // namespace

FractionalDelay::FractionalDelay() {
    static const AlignedVector<float> table = make_table(kPhases);
    table_ = table.data();
}

std::array<float, kInterpolationTaps> FractionalDelay::impulse(double fraction) const {
    const double phase = fraction * static_cast<double>(kPhases);
    const auto row = static_cast<std::size_t>(phase);
    const auto share = static_cast<float>(phase - static_cast<double>(row));
    std::array<float, kInterpolationTaps> taps;
    for (std::size_t k = 0; k < kInterpolationTaps; ++k) {
        const float a = table_[row * kInterpolationTaps + k];
        taps[k] = a + share * (table_[(row + 1) * kInterpolationTaps + k] - a);
    }
    return taps;
}

}  // namespace aula
