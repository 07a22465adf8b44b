#include "audio/dsp/minimum_phase.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

namespace minimum_phase_test {

using namespace aula;

namespace {

using Complex = std::complex<double>;

constexpr std::size_t kSize = 512;

/// The response of taps at the frequencies of a transform of kSize.
std::vector<Complex> response_of(const std::vector<double>& taps) {
    std::vector<Complex> response(kSize / 2 + 1);
    for (std::size_t k = 0; k < response.size(); ++k) {
        for (std::size_t n = 0; n < taps.size(); ++n)
            response[k] += taps[n] * std::polar(1.0, -2 * std::numbers::pi *
                                                         static_cast<double>(k * n) / kSize);
    }
    return response;
}

/// The minimum-phase response with the magnitude of the given one.
std::vector<Complex> minimum_phase_of(const std::vector<Complex>& response) {
    MinimumPhase phase(kSize);
    std::vector<float> log_magnitude;
    for (const Complex& h : response)
        log_magnitude.push_back(static_cast<float>(std::log(std::abs(h))));
    std::vector<std::complex<float>> log_response(phase.bins());
    phase.complete(log_magnitude, log_response);
    std::vector<Complex> completed;
    for (const auto& bin : log_response) completed.push_back(std::exp(Complex(bin)));
    return completed;
}

double worst_difference(const std::vector<Complex>& a, const std::vector<Complex>& b) {
    double worst = 0;
    for (std::size_t k = 0; k < a.size(); ++k) worst = std::max(worst, std::abs(a[k] - b[k]));
    return worst;
}

// Rounding: 2 transforms of 9 stages in single precision of a cepstrum of magnitude 1, and the
// exponential; times 4. The cepstrum of a zero at radius 0.8 aliases by 0.8^256: nothing.
constexpr double kError = 2 * 9 * 0x1p-24 * 2 * 4;

}  // namespace

TEST_CASE("A response with all zeros inside the unit circle is recovered from its magnitude") {
    for (const std::vector<double>& taps :
         {std::vector<double>{1}, {1, -0.8}, {1, 0.5}, {1, 0, 0.64}, {1, -0.3, 0.02}}) {
        const std::vector<Complex> response = response_of(taps);
        CAPTURE(taps);
        CHECK(worst_difference(minimum_phase_of(response), response) < kError);
    }
}

TEST_CASE("A zero outside the unit circle moves to its reciprocal inside") {
    // 0.5 + z^-1 has its zero at -2, 1 + 0.5 z^-1 at -0.5; the magnitudes are equal.
    const std::vector<Complex> outside = response_of({0.5, 1});
    const std::vector<Complex> inside = response_of({1, 0.5});
    CHECK(worst_difference(minimum_phase_of(outside), inside) < kError);
    // Companion: the phases differ.
    CHECK(worst_difference(outside, inside) > 0.5);
}

TEST_CASE("The minimum phase of a delay is zero: the delay is removed") {
    const std::vector<Complex> delayed = response_of({0, 0, 0, 1, -0.6});
    CHECK(worst_difference(minimum_phase_of(delayed), response_of({1, -0.6})) < kError);
}

TEST_CASE("The magnitude is kept, and a gain adds no phase") {
    MinimumPhase phase(kSize);
    REQUIRE(phase.bins() == kSize / 2 + 1);
    std::vector<float> log_magnitude(phase.bins());
    for (std::size_t k = 0; k < log_magnitude.size(); ++k)
        log_magnitude[k] = std::sin(0.37F * static_cast<float>(k * k % 97)) - 1.5F;
    std::vector<std::complex<float>> log_response(phase.bins());
    phase.complete(log_magnitude, log_response);
    for (float& x : log_magnitude) x += 3;
    std::vector<std::complex<float>> louder(phase.bins());
    phase.complete(log_magnitude, louder);
    for (std::size_t k = 0; k < log_response.size(); ++k) {
        // Rounding: 18 stages on magnitudes of at most 3.
        CHECK(louder[k].real() == Approx(log_magnitude[k]).margin(1e-5));
        CHECK(louder[k].real() - log_response[k].real() == Approx(3).margin(1e-5));
        CHECK(louder[k].imag() == Approx(log_response[k].imag()).margin(1e-5));
    }
    // A real signal has real values at 0 Hz and at the Nyquist frequency.
    CHECK(louder.front().imag() == 0);
    CHECK(louder.back().imag() == 0);
}

}  // namespace minimum_phase_test
