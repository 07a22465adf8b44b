#include "engine/base/fft.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <numbers>

#include "engine/base/sampling.h"

using aula::Fft;

TEST_CASE("the transform is the sum over the signal, and its inverse returns the signal") {
    for (const std::size_t size : {1U, 2U, 3U, 4U, 5U, 8U, 30U, 100U, 720U}) {
        CAPTURE(size);
        aula::RandomStream random(size);
        std::vector<float> real(size), imaginary(size);
        for (float& x : real) x = random.uniform() - 0.5F;
        for (float& x : imaginary) x = random.uniform() - 0.5F;
        std::vector<float> a = real, b = imaginary;
        Fft fft(size);
        fft.forward(a, b);
        // Rounding of single precision, with the square root of the number of terms.
        const double rounding = 1e-6 * std::sqrt(static_cast<double>(size));
        for (std::size_t k = 0; k < size; ++k) {
            std::complex<double> sum;
            for (std::size_t n = 0; n < size; ++n) {
                const double angle = -2 * std::numbers::pi * static_cast<double>(k * n % size) /
                                     static_cast<double>(size);
                sum += std::complex<double>(double{real[n]}, double{imaginary[n]}) *
                       std::polar(1.0, angle);
            }
            CHECK(std::abs(sum - std::complex<double>(double{a[k]}, double{b[k]})) < rounding);
        }
        fft.inverse(a, b);
        for (std::size_t n = 0; n < size; ++n) {
            CHECK(double{a[n]} / static_cast<double>(size) ==
                  Approx(double{real[n]}).margin(rounding));
            CHECK(double{b[n]} / static_cast<double>(size) ==
                  Approx(double{imaginary[n]}).margin(rounding));
        }
    }
}

TEST_CASE("signals that are transformed together have the results that they have alone") {
    constexpr std::size_t kSize = 60;
    for (const std::size_t signals : {2U, 3U, 5U}) {
        CAPTURE(signals);
        aula::RandomStream random(signals);
        std::vector<float> real(kSize * signals), imaginary(kSize * signals);
        for (float& x : real) x = random.uniform() - 0.5F;
        for (float& x : imaginary) x = random.uniform() - 0.5F;
        std::vector<float> all_real = real, all_imaginary = imaginary;
        Fft(kSize).forward(all_real, all_imaginary);
        for (std::size_t i = 0; i < signals; ++i) {
            std::vector<float> a(kSize), b(kSize);
            for (std::size_t n = 0; n < kSize; ++n) {
                a[n] = real[n * signals + i];
                b[n] = imaginary[n * signals + i];
            }
            Fft(kSize).forward(a, b);
            for (std::size_t k = 0; k < kSize; ++k) {
                CHECK(all_real[k * signals + i] == a[k]);
                CHECK(all_imaginary[k * signals + i] == b[k]);
            }
        }
    }
}

TEST_CASE("fast sizes are multiples without prime factors above 5") {
    CHECK(Fft::fast_size(384000, 16) == 384000);
    CHECK(Fft::fast_size(64008, 2) == 64800);
    CHECK(Fft::fast_size(7, 1) == 8);
    CHECK(Fft::fast_size(1, 16) == 16);
    CHECK(Fft::fast_size(17, 16) == 32);
}
