#include "audio/convolution/block_transform.h"

#include <algorithm>
#include <bit>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <vector>

using namespace aula;

namespace {

AlignedVector<float> noise(std::size_t samples, unsigned seed) {
    std::mt19937 random(seed);
    std::normal_distribution<float> normal;
    AlignedVector<float> signal(samples);
    for (float& x : signal) x = normal(random);
    return signal;
}

/// Sample n of the newer half of a window convolved with a filter, by the definition.
double exact(const AlignedVector<float>& window, const AlignedVector<float>& taps, std::size_t n) {
    double sum = 0;
    for (std::size_t k = 0; k < taps.size(); ++k) {
        sum += double{taps[k]} * double{window[taps.size() + n - k]};
    }
    return sum;
}

}  // namespace

TEST_CASE("The product of spectra is a convolution with every instruction set") {
    for (const SpectralKernels* const kernels : available_kernels()) {
        for (std::size_t size = 16; size <= 8192; size *= 2) {
            CAPTURE(kernels->name, size);
            const BlockTransform transform(size, *kernels);
            const AlignedVector<float> window = noise(2 * size, 1);
            const AlignedVector<float> taps = noise(size, 2);
            AlignedVector<float> work(transform.work_floats());
            AlignedVector<float> signal_spectrum(2 * size);
            AlignedVector<float> filter_spectrum(2 * size);
            AlignedVector<float> sums(2 * size);
            AlignedVector<float> out(size);
            transform.forward(window.data(), window.data() + size, work.data(),
                              signal_spectrum.data());
            const float* const filter = taps.data();
            transform.forward_filters({&filter, 1}, work.data(), filter_spectrum.data());
            const SpectralTerm term{signal_spectrum.data(), filter_spectrum.data(), 1};
            kernels->multiply_add({&term, 1}, 1, 0, transform.chunks(), sums.data());
            transform.inverse(sums.data(), kChunk_floats, work.data(), out.data());
            double worst = 0;
            for (std::size_t n = 0; n < size; n += 1 + size / 256) {
                worst = std::max(worst, std::abs(double{out[n]} - exact(window, taps, n)));
            }
            // Rounding: three transforms of 13 stages and a product, 2^-24 each, of sums of
            // magnitude sqrt(8192) = 91 with independent errors: 3.5e-5; times 3.
            CHECK(worst < 1e-4);
        }
    }
}

TEST_CASE("A transform in steps equals the whole transform") {
    // The end passes have several parts from 512 on, the other passes from 2048 on.
    const std::size_t size = GENERATE(256U, 512U, 2048U, 4096U, 8192U);
    const BlockTransform transform(size);
    const AlignedVector<float> window = noise(2 * size, 3);
    AlignedVector<float> work(transform.work_floats());
    AlignedVector<float> whole(2 * size);
    transform.forward(window.data(), window.data() + size, work.data(), whole.data());
    // The second of three interleaved spectra is written.
    AlignedVector<float> interleaved(3 * 2 * size);
    for (std::size_t step = 0; step < transform.steps(); ++step) {
        transform.forward_step(step, window.data(), window.data() + size, work.data(),
                               interleaved.data() + kChunk_floats, 3 * kChunk_floats);
    }
    bool same = true;
    for (std::size_t c = 0; c < transform.chunks(); ++c) {
        same &= std::equal(
            whole.begin() + static_cast<std::ptrdiff_t>(c * kChunk_floats),
            whole.begin() + static_cast<std::ptrdiff_t>((c + 1) * kChunk_floats),
            interleaved.begin() + static_cast<std::ptrdiff_t>((3 * c + 1) * kChunk_floats));
    }
    CHECK(same);
}

TEST_CASE("Filters transformed together have the spectra of each filter alone, interleaved") {
    const std::size_t size = GENERATE(16U, 512U, 4096U);
    const BlockTransform transform(size);
    std::vector<AlignedVector<float>> taps;
    std::vector<const float*> pointers;
    for (unsigned f = 0; f < 3; ++f) pointers.push_back(taps.emplace_back(noise(size, f)).data());
    AlignedVector<float> work(3 * transform.work_floats());
    AlignedVector<float> together(3 * 2 * size);
    transform.forward_filters(pointers, work.data(), together.data());
    AlignedVector<float> separate(3 * 2 * size);
    for (std::size_t f = 0; f < 3; ++f) {
        for (std::size_t step = 0; step < transform.steps(); ++step) {
            transform.forward_step(step, pointers[f], nullptr, work.data(),
                                   separate.data() + f * kChunk_floats, 3 * kChunk_floats);
        }
    }
    CHECK(together == separate);
}

TEST_CASE("Every instruction set sums the same products, in single and in half precision") {
    constexpr std::size_t kChunks = 9;
    constexpr std::size_t kTerms = 5;
    const SpectralKernels& portable = *available_kernels().front();
    for (const std::size_t outputs : {1U, 2U, 3U, 4U, 7U, 8U, 13U, 16U}) {
        const std::size_t floats = kChunks * outputs * kChunk_floats;
        std::vector<AlignedVector<float>> inputs;
        std::vector<AlignedVector<float>> filters;
        std::vector<AlignedVector<std::uint16_t>> halves;
        for (unsigned k = 0; k < kTerms; ++k) {
            inputs.push_back(noise(kChunks * kChunk_floats, 10 + k));
            filters.push_back(noise(floats, 20 + k));
            halves.emplace_back(floats);
            portable.to_half(filters.back().data(), floats, 1, halves.back().data());
        }
        for (const SpectralKernels* const kernels : available_kernels()) {
            for (const bool half : {false, true}) {
                CAPTURE(kernels->name, outputs, half);
                std::vector<SpectralTerm> terms;
                for (std::size_t k = 0; k < kTerms; ++k) {
                    const void* const h = half ? static_cast<const void*>(halves[k].data())
                                               : static_cast<const void*>(filters[k].data());
                    terms.push_back({inputs[k].data(), h, half ? 0.5F : 1.0F});
                }
                // Added to existing sums, for a part of the chunks.
                AlignedVector<float> sums = noise(floats, 30);
                const AlignedVector<float> before = sums;
                const auto sum = half ? kernels->multiply_add_half : kernels->multiply_add;
                sum({terms.data(), terms.size()}, outputs, 1, kChunks - 1, sums.data());
                double worst = 0;
                for (std::size_t n = 0; n < floats; ++n) {
                    const std::size_t chunk = n / (outputs * kChunk_floats);
                    const bool imaginary = n % kChunk_floats >= kChunk_bins;
                    const std::size_t re = imaginary ? n - kChunk_bins : n;
                    const std::size_t x = chunk * kChunk_floats + n % kChunk_bins;
                    double expected = before[n];
                    for (std::size_t k = 0; k < kTerms && chunk > 0 && chunk + 1 < kChunks; ++k) {
                        const double x_re = inputs[k][x];
                        const double x_im = inputs[k][x + kChunk_bins];
                        const double h_re = filters[k][re];
                        const double h_im = filters[k][re + kChunk_bins];
                        expected += (half ? 0.5 : 1.0) * (imaginary ? x_re * h_im + x_im * h_re
                                                                    : x_re * h_re - x_im * h_im);
                    }
                    worst = std::max(worst, std::abs(double{sums[n]} - expected));
                }
                // Rounding of ten products of up to 4 x 4: 2^-24 each, filters 2^-11 (times 1/2).
                CHECK(worst < (half ? 10 * 16 * 0x1p-12 : 10 * 16 * 0x1p-23));
                if (half) CHECK(worst > 1e-4);
            }
        }
    }
}

TEST_CASE("Every instruction set rounds to half precision equally") {
    constexpr std::size_t kCount = 4096;
    AlignedVector<float> numbers = noise(kCount, 40);
    // All magnitudes, from subnormal numbers to the largest.
    for (std::size_t n = 0; n < kCount; ++n) {
        numbers[n] *= std::exp2(static_cast<float>(n % 32) - 18);
    }
    numbers[0] = 0;
    numbers[1] = -32768;
    AlignedVector<std::uint16_t> first;
    for (const SpectralKernels* const kernels : available_kernels()) {
        CAPTURE(kernels->name);
        AlignedVector<std::uint16_t> halves(kCount);
        kernels->to_half(numbers.data(), kCount, 1, halves.data());
        if (first.empty()) first = halves;
        for (std::size_t n = 0; n < kCount; ++n) {
            // The value by the definition of the format.
            const int exponent = halves[n] >> 10 & 0x1f;
            const int fraction = halves[n] & 0x3ff;
            const double size = exponent == 0 ? std::ldexp(fraction, -24)
                                              : std::ldexp(1024 + fraction, exponent - 25);
            const double value = halves[n] & 0x8000 ? -size : size;
            // Half a unit in the last place.
            const double allowed = std::max(std::abs(double{numbers[n]}) * 0x1p-11, 0x1p-25);
            CHECK(std::abs(value - double{numbers[n]}) <= allowed);
            // Ties of subnormal numbers may round either way.
            CHECK((halves[n] == first[n] || size < 0x1p-14));
        }
    }
}

TEST_CASE("The portable kernels come first on every machine, the fastest last") {
    const std::vector<const SpectralKernels*> kernels = available_kernels();
    REQUIRE_FALSE(kernels.empty());
    CHECK(kernels.front()->lanes == 4);
    CHECK(&best_kernels() == kernels.back());
    for (std::size_t i = 1; i < kernels.size(); ++i) {
        CHECK(kernels[i]->lanes > kernels[i - 1]->lanes);
    }
}
