#include "audio/spatial/response_splitter.h"

#include <catch2/catch.hpp>
#include <complex>
#include <cstddef>
#include <numbers>
#include <vector>

namespace response_splitter_test {

using namespace aula;

namespace {

constexpr std::size_t kSamples = 256;

/// A low-pass response of minimum phase after a delay. At the Nyquist frequency, where a delay of a
/// part of a sample would change the magnitude, it has nothing.
std::vector<float> delayed(double samples) {
    RealFft fft(kSamples);
    std::vector<std::complex<float>> spectrum(fft.bins());
    for (std::size_t k = 0; k < fft.bins(); ++k) {
        const std::complex<double> turn = std::polar(
            1.0, -2 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(kSamples));
        spectrum[k] = std::complex<float>(std::pow(turn, samples) * std::pow(1.0 + turn, 4) /
                                          (1.0 - 0.6 * turn));
    }
    std::vector<float> response(kSamples);
    fft.inverse(spectrum.data(), response.data());
    for (float& x : response) x /= static_cast<float>(kSamples);
    return response;
}

}  // namespace

TEST_CASE("The delays of responses are found to a ten thousandth of a sample") {
    for (const double rate_hz : {44100.0, 96000.0}) {
        std::vector<EarPair> pairs;
        std::vector<double> delays;
        for (int tenths = 0; tenths <= 10; ++tenths) {
            delays.push_back(0.1 * tenths);
            pairs.push_back({delayed(20 + delays.back()), delayed(20)});
        }
        ResponseSplitter splitter(kSamples, 128, rate_hz);
        const auto split = splitter.split(pairs);
        for (std::size_t i = 0; i < pairs.size(); ++i) {
            CAPTURE(rate_hz, delays[i]);
            const double samples = (split[i][0].delay_s - split[i][1].delay_s) * rate_hz;
            CHECK(samples == Approx(delays[i]).margin(1e-4));
        }
    }
}

}  // namespace response_splitter_test
