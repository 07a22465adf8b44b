#include "engine/response/band_pass.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <complex>
#include <numbers>

namespace aula {

namespace {

using Complex = std::complex<double>;

constexpr int kOrder = 3;  // IEC 61260-1, class 1

/// (1 - z^-2) / (1 + a1 z^-1 + a2 z^-2) times a gain.
struct Biquad {
    double gain = 1, a1 = 0, a2 = 0;

    /// Of two poles that are conjugate or real.
    static Biquad of_poles(Complex a, Complex b) {
        return {.a1 = -(a + b).real(), .a2 = (a * b).real()};
    }

    double magnitude(double radians) const {
        const Complex z = std::polar(1.0, -radians);
        return gain * std::abs((1.0 - z * z) / (1.0 + a1 * z + a2 * z * z));
    }

    template <typename Iterator>
    void process(Iterator begin, Iterator end) const {
        double s1 = 0;
        double s2 = 0;
        for (Iterator x = begin; x != end; ++x) {
            const double in = gain * *x;
            const double out = in + s1;
            s1 = s2 - a1 * out;
            s2 = -in - a2 * out;
            *x = out;
        }
    }
};

/// The band-pass as one section for each pole of the low-pass that it is transformed from.
std::array<Biquad, kOrder> sections(const FrequencyBand& band, double sample_rate_hz) {
    // Edges on the axis of the bilinear transform z = (1 + s) / (1 - s).
    const double low = std::tan(std::numbers::pi * band.low_hz / sample_rate_hz);
    const double high = std::tan(std::numbers::pi * band.high_hz / sample_rate_hz);
    const double centre = std::sqrt(low * high);
    // Both passes: |H|^4 = (1 + x^(2 N))^-2 = 1/2 at x = (high - low) / width.
    const double width = (high - low) / std::pow(std::numbers::sqrt2 - 1, 1.0 / (2 * kOrder));
    const auto digital = [](Complex s) { return (1.0 + s) / (1.0 - s); };
    // A pole p of the low-pass becomes the two roots of s^2 - p width s + centre^2.
    const auto roots = [&](Complex p) {
        const Complex half = p * width / 2.0;
        const Complex root = std::sqrt(half * half - centre * centre);
        return std::array{digital(half + root), digital(half - root)};
    };
    static_assert(kOrder == 3, "poles at -1 and at 120 degrees");
    const auto real = roots(-1);
    const auto complex = roots(std::polar(1.0, 2 * std::numbers::pi / 3));
    std::array<Biquad, kOrder> all{Biquad::of_poles(real[0], real[1]),
                                   Biquad::of_poles(complex[0], std::conj(complex[0])),
                                   Biquad::of_poles(complex[1], std::conj(complex[1]))};
    const double middle = 2 * std::atan(centre);
    double magnitude = 1;
    for (const Biquad& section : all) magnitude *= section.magnitude(middle);
    for (Biquad& section : all) section.gain = std::pow(magnitude, -1.0 / kOrder);
    return all;
}

}  // namespace

FrequencyBand FrequencyBand::at(int index, int per_octave) {
    const double centre_hz = 1000 * std::pow(10, 0.3 * index / per_octave);
    const double half = std::pow(10, 0.15 / per_octave);
    return {centre_hz / half, centre_hz * half};
}

std::vector<double> band_passed(std::span<const float> signal, double sample_rate_hz,
                                const FrequencyBand& band, std::size_t ahead) {
    assert(band.high_hz < sample_rate_hz / 2);
    const auto behind = static_cast<std::size_t>(2 * band.ringing_s() * sample_rate_hz);
    std::vector<double> filtered(ahead + signal.size() + behind);
    std::copy(signal.begin(), signal.end(), filtered.begin() + static_cast<std::ptrdiff_t>(ahead));
    for (const Biquad& section : sections(band, sample_rate_hz)) {
        section.process(filtered.begin(), filtered.end());
        section.process(filtered.rbegin(), filtered.rend());
    }
    filtered.resize(ahead + signal.size());
    return filtered;
}

}  // namespace aula
