#include "audio/file/sample_quantizer.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <vector>

using aula::SampleQuantizer;

namespace {

constexpr double kStep = 0x1p-15;  // of 16 bits

struct Error {
    double mean_steps = 0;
    double variance_steps = 0;
};

/// The error of `count` samples, each of this many steps.
Error error_at(double steps, SampleQuantizer& quantizer, std::size_t count) {
    std::vector<int> integers;
    quantizer.quantize(std::vector<float>(count, static_cast<float>(steps * kStep)), integers);
    Error error;
    for (const int integer : integers) {
        const double e = integer / 65536 - steps;
        error.mean_steps += e / static_cast<double>(count);
        error.variance_steps += e * e / static_cast<double>(count);
    }
    error.variance_steps -= error.mean_steps * error.mean_steps;
    return error;
}

}  // namespace

TEST_CASE("Mean and variance of the error of dithered samples do not depend on the signal") {
    constexpr std::size_t kCount = 100'000;
    for (const double steps : {0.0, 0.1, 0.25, 0.5, 0.9, -0.3, -100.75, 1000.125}) {
        SampleQuantizer dithered(16, 1);
        const Error error = error_at(steps, dithered, kCount);
        CAPTURE(steps);
        // Statistical, 5 standard errors: the variance is 1/12 + 2/12. The fourth moment of a sum
        // of three uniform numbers is 13/80, so that of the variance has the deviation
        // sqrt((13/80 - 1/16) / n).
        CHECK(std::abs(error.mean_steps) < 5 * std::sqrt(0.25 / kCount));
        CHECK(std::abs(error.variance_steps - 0.25) < 5 * std::sqrt(0.1 / kCount));
    }
    // Companion: without dither the error is that of the sample.
    SampleQuantizer rounded(16, std::nullopt);
    CHECK(std::abs(error_at(0.25, rounded, kCount).mean_steps + 0.25) < 1e-6);
    CHECK(error_at(0.25, rounded, kCount).variance_steps < 1e-6);
}

TEST_CASE("Samples without dither are rounded to the nearest integer, without an offset") {
    constexpr int kCount = 100'001;
    std::vector<float> samples;
    for (int n = 0; n < kCount; ++n)
        samples.push_back(0.9F * std::sin(static_cast<float>(n) * 0.7F));
    SampleQuantizer rounded(16, std::nullopt);
    std::vector<int> integers;
    rounded.quantize(samples, integers);
    double mean = 0;
    double cut_mean = 0;
    for (std::size_t n = 0; n < samples.size(); ++n) {
        const double steps = double{samples[n]} / kStep;
        const double error = integers[n] / 65536 - steps;
        REQUIRE(std::abs(error) <= 0.5);
        mean += error / kCount;
        cut_mean += (std::floor(steps) - steps) / kCount;
    }
    // Statistical, 5 standard errors of a uniform error.
    const double bound = 5 * std::sqrt(1.0 / 12 / kCount);
    CHECK(std::abs(mean) < bound);
    // Companion: the error of samples that are cut off has a mean of -1/2.
    CHECK(std::abs(cut_mean) > 100 * bound);
}

TEST_CASE("A tone of less than half a step survives by dither") {
    constexpr int kCount = 48'000;
    constexpr double kAmplitude_steps = 0.4;
    const auto tone = [](int n) { return std::sin(2 * std::numbers::pi * n / 48); };
    std::vector<float> samples;
    for (int n = 0; n < kCount; ++n)
        samples.push_back(static_cast<float>(kAmplitude_steps * kStep * tone(n)));
    const auto amplitude = [&](SampleQuantizer quantizer) {
        std::vector<int> integers;
        quantizer.quantize(samples, integers);
        double sum = 0;
        for (int n = 0; n < kCount; ++n)
            sum += integers[static_cast<std::size_t>(n)] / 65536 * tone(n);
        return 2 * sum / kCount;
    };
    // Statistical, 5 standard errors of the variance 1/4.
    CHECK(std::abs(amplitude(SampleQuantizer(16, 1)) - kAmplitude_steps) <
          5 * std::sqrt(2 * 0.25 / kCount));
    // Companion: it is silent without.
    CHECK(amplitude(SampleQuantizer(16, std::nullopt)) == 0);
}

TEST_CASE("The seed determines the dither, in any division into parts") {
    const std::vector<float> silence(1000);
    std::vector<int> whole;
    SampleQuantizer(24, 7).quantize(silence, whole);
    SampleQuantizer again(24, 7);
    std::vector<int> parts;
    std::vector<int> part;
    for (const std::size_t size : {1U, 400U, 599U}) {
        again.quantize(std::span(silence).first(size), part);
        parts.insert(parts.end(), part.begin(), part.end());
    }
    CHECK(parts == whole);
    SampleQuantizer(24, 8).quantize(silence, parts);
    CHECK(parts != whole);
}

TEST_CASE("Samples beyond full scale are clipped, with dither and without") {
    for (const std::optional<std::uint64_t> seed : {std::optional<std::uint64_t>(), {1}}) {
        std::vector<int> integers;
        SampleQuantizer(16, seed).quantize(std::vector<float>{1.1F, -1.1F, 3e38F, -3e38F},
                                           integers);
        CHECK(integers ==
              std::vector<int>{32767 * 65536, -32768 * 65536, 32767 * 65536, -32768 * 65536});
    }
}
