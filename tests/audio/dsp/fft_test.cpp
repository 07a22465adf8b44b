#include "audio/dsp/fft.h"

#include <catch2/catch.hpp>
#include <complex>
#include <numbers>
#include <random>

#include "audio/base/aligned.h"

using namespace aula;

TEST_CASE("The Fourier transform agrees with its definition") {
    const std::size_t size = GENERATE(as<std::size_t>{}, 8, 30, 96, 512);
    RealFft fft(size);
    std::mt19937 random(1);
    std::normal_distribution<float> normal;
    AlignedVector<float> signal(size);
    for (float& x : signal) x = normal(random);
    AlignedVector<std::complex<float>> spectrum(fft.bins());
    fft.forward(signal.data(), spectrum.data());
    for (std::size_t k = 0; k < fft.bins(); ++k) {
        std::complex<double> sum = 0;
        for (std::size_t n = 0; n < size; ++n) {
            const double angle = -2 * std::numbers::pi * static_cast<double>((k * n) % size) /
                                 static_cast<double>(size);
            sum += double{signal[n]} * std::polar(1.0, angle);
        }
        // Rounding: log2(512) = 9 stages of 2^-24 on sums of magnitude sqrt(512) = 23, times 4.
        CHECK(std::abs(std::complex<double>(spectrum[k]) - sum) < 5e-5);
    }
}

TEST_CASE("The inverse Fourier transform gives the signal times the size") {
    const std::size_t size = GENERATE(as<std::size_t>{}, 16, 450, 1024);
    RealFft fft(size);
    std::mt19937 random(2);
    std::normal_distribution<float> normal;
    AlignedVector<float> signal(size);
    for (float& x : signal) x = normal(random);
    const AlignedVector<float> original = signal;
    AlignedVector<std::complex<float>> spectrum(fft.bins());
    fft.forward(signal.data(), spectrum.data());
    REQUIRE(signal == original);
    fft.inverse(spectrum.data(), signal.data());
    for (std::size_t n = 0; n < size; ++n) {
        // Rounding: 20 stages of 2^-24 on values of magnitude 3, times 3.
        CHECK(signal[n] / static_cast<float>(size) == Approx(original[n]).margin(1e-5));
    }
}

TEST_CASE("The fast size is the next even number with prime factors 2, 3 and 5 only") {
    CHECK(fast_fft_size(2) == 2);
    CHECK(fast_fft_size(7) == 8);
    CHECK(fast_fft_size(512) == 512);
    CHECK(fast_fft_size(513) == 540);
    CHECK(fast_fft_size(882) == 900);
}
