#include "engine/response/octave_bank.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <numbers>

using aula::kBandCount;
using aula::OctaveBank;

namespace {

using Spectrum = std::array<std::complex<double>, kBandCount>;

/// Frequency responses of the bands from two seconds of their impulse responses. The truncation
/// error is below 1e-12 (the slowest pole has a time constant of 17 ms).
class Responses {
 public:
    explicit Responses(double sample_rate_hz) : sample_rate_hz_(sample_rate_hz) {
        std::vector<double> impulse(static_cast<std::size_t>(2 * sample_rate_hz));
        impulse[0] = 1;
        impulse_ = OctaveBank(sample_rate_hz).process(impulse);
    }

    Spectrum at(double frequency_hz) const {
        Spectrum h{};
        const std::complex<double> step =
            std::polar(1.0, -2 * std::numbers::pi * frequency_hz / sample_rate_hz_);
        std::complex<double> phase = 1;
        for (const auto& bands : impulse_) {
            for (std::size_t b = 0; b < kBandCount; ++b) h[b] += bands[b] * phase;
            phase *= step;
        }
        return h;
    }

 private:
    double sample_rate_hz_;
    std::vector<std::array<double, kBandCount>> impulse_;
};

constexpr std::array<double, 12> kFrequencies_hz{0,   20,   44.2, 88.4, 100,  176.8,
                                                 500, 1000, 1414, 4000, 5656, 20000};

}  // namespace

TEST_CASE("the power responses of the octave bands sum to 1 at every frequency") {
    const Responses responses(48000);
    for (const double f : kFrequencies_hz) {
        double power = 0;
        for (const auto& h : responses.at(f)) power += std::norm(h);
        CHECK(power == Approx(1).epsilon(1e-9));  // rounding of 96,000 terms
    }
}

TEST_CASE("the octave bands sum to an all-pass") {
    const Responses responses(48000);
    for (const double f : kFrequencies_hz) {
        std::complex<double> sum = 0;
        for (const auto& h : responses.at(f)) sum += h;
        CHECK(std::abs(sum) == Approx(1).epsilon(1e-9));
    }
}

TEST_CASE("an octave band passes its own octave and nothing else") {
    const Responses responses(48000);
    for (std::size_t b = 0; b < kBandCount; ++b) {
        const double centre_hz = 1000 * std::pow(2.0, static_cast<double>(b) - 4);
        const Spectrum h = responses.at(centre_hz);
        // Order 15, half an octave from both edges: 1/(1 + 2^-15) at each.
        CHECK(std::norm(h[b]) > 0.9999);
        // 1.5 octaves or more from the next edge: 2^(-15 * 3), and rounding.
        for (std::size_t o = 0; o < kBandCount; ++o) {
            if (o + 1 < b || o > b + 1) CHECK(std::norm(h[o]) < 1e-12);
        }
        // At the edge both bands have half of the power.
        if (b > 0)
            CHECK(std::norm(responses.at(centre_hz / std::sqrt(2.0))[b]) ==
                  Approx(0.5).epsilon(0.01));
    }
}

TEST_CASE("bands above the Nyquist frequency are silent and the others sum to 1") {
    const Responses responses(8000);  // Nyquist frequency 4 kHz: the 8 kHz octave is silent
    for (const double f : {50.0, 1000.0, 2828.0, 3900.0}) {
        const Spectrum h = responses.at(f);
        double power = 0;
        for (const auto& x : h) power += std::norm(x);
        CHECK(power == Approx(1).epsilon(1e-9));
        CHECK(std::norm(h[7]) == 0);
    }
}
