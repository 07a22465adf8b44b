#include "aula/audio/convolver.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "audio/convolution/partition_levels.h"
#include "tests/audio/convolution/convolution.h"

namespace convolver_test {

using namespace aula;
using namespace aula::test;

namespace {

// Rounding: outputs have magnitudes of 1 to 4 (inputs of unit variance, responses of unit energy,
// up to 3 inputs). The transforms and sums add about 30 roundings of 2^-24 of a bin's magnitude.
// 1e-5 is 5 times the observed error.
constexpr double kRounding = 1e-5;

// Spectra rounded to half precision: errors uniform over 2^-10 of the power of two below a number
// have an RMS of 2.1e-4 of its magnitude, and so has the output, here of unit variance. One of 10^7
// samples exceeds 5.5 standard deviations.
constexpr double kHalfRounding = 5.5 * 2.1e-4;

}  // namespace

TEST_CASE("Convolution agrees with its definition for any shape and any call size") {
    struct Case {
        ConvolutionShape shape;
        std::size_t taps;
        std::vector<std::size_t> calls;
    };
    const Case c = GENERATE(Case{{1, 1, 64, 1000}, 1000, {64}},          // whole blocks
                            Case{{1, 2, 64, 1000}, 1, {64}},             // a filter of one tap
                            Case{{2, 3, 64, 1000}, 300, {64}},           // shorter than it may be
                            Case{{1, 1, 256, 200}, 200, {256}},          // one partition
                            Case{{3, 2, 64, 500}, 500, {1, 7, 64, 30}},  // varying calls
                            Case{{1, 2, 441, 2000}, 2000, {441}},        // an odd block
                            Case{{1, 1, 1, 40}, 40, {1}},                // the smallest block
                            Case{{1, 1, 16, 100}, 100, {5}});
    CAPTURE(c.shape.inputs, c.shape.outputs, c.shape.block, c.taps);
    const Signals inputs = random_signals(c.shape.inputs, 3000, 1);
    const Responses responses = random_responses(c.shape, c.taps, 100);
    const ConvolutionFilter filter = make_filter(c.shape, responses);
    Convolver convolver(c.shape, 0);
    convolver.exchange(&filter);
    Signals outputs(c.shape.outputs, Signal(3000));
    run(convolver, inputs, outputs, 0, 3000, c.calls);
    CHECK(worst_error(outputs, direct(inputs, responses)) < kRounding);
}

TEST_CASE("Convolution through several levels agrees with its definition") {
    struct Case {
        ConvolutionShape shape;
        std::size_t levels;
        std::vector<std::size_t> calls;
    };
    const Case c = GENERATE(Case{{1, 2, 128, 20000}, 3, {128}},             //
                            Case{{2, 1, 128, 20000}, 3, {3, 128, 77, 16}},  // varying calls
                            Case{{1, 1, 16, 12000}, 4, {16}},               //
                            Case{{1, 1, 512, 20000}, 2, {512, 480}},        //
                            Case{{1, 1, 4096, 20000}, 1, {4096}},  // larger sizes start too late
                            Case{{1, 1, 8192, 20000}, 1, {8192}},  // the largest block
                            Case{{1, 5, 64, 9000}, 3, {64}},       // odd outputs
                            Case{{1, 1, 128, 20000, true}, 3, {128}});
    CAPTURE(c.shape.inputs, c.shape.outputs, c.shape.block, c.shape.half_precision_tail);
    REQUIRE(partition_levels(c.shape).size() == c.levels);
    const std::size_t samples = 36000;
    const Signals inputs = random_signals(c.shape.inputs, samples, 2);
    const Responses responses = random_responses(c.shape, c.shape.taps, 200);
    const ConvolutionFilter filter = make_filter(c.shape, responses);
    Convolver convolver(c.shape, 0);
    convolver.exchange(&filter);
    Signals outputs(c.shape.outputs, Signal(samples));
    run(convolver, inputs, outputs, 0, samples, c.calls);
    const double error = worst_error(outputs, direct(inputs, responses));
    CHECK(error < (c.shape.half_precision_tail ? kHalfRounding : kRounding));
    // The errors of half and of single precision differ.
    if (c.shape.half_precision_tail) CHECK(error > 10 * kRounding);
}

TEST_CASE("A response of 10 s agrees with the definition up to its last tap") {
    const bool half = GENERATE(false, true);
    constexpr std::size_t kTaps = 480000;
    const ConvolutionShape shape{1, 1, 128, kTaps, half};
    const std::size_t samples = kTaps + 40000;
    const Signals inputs = random_signals(1, samples, 4);
    // Without decay, so that the last tap weighs as much as the first.
    const Responses responses = random_responses(shape, kTaps, 400);
    const ConvolutionFilter filter = make_filter(shape, responses);
    Convolver convolver(shape, 0);
    convolver.exchange(&filter);
    Signals outputs(1, Signal(samples));
    run(convolver, inputs, outputs, 0, samples, {128});
    // Twice the rounding of shorter responses: 37 more partitions are summed.
    const double rounding = half ? kHalfRounding : 2 * kRounding;
    double without_last = 0;
    for (std::size_t n = 5000; n < samples; n += 9973) {
        double expected = 0;
        for (std::size_t k = 0; k <= std::min(n, kTaps - 1); ++k) {
            expected += double{responses[0][0][k]} * double{inputs[0][n - k]};
        }
        CAPTURE(half, n);
        CHECK(std::abs(double{outputs[0][n]} - expected) < rounding);
        // Companion: without the last partition the result differs.
        if (n < kTaps) continue;
        for (std::size_t k = kTaps - 8192; k < kTaps; ++k) {
            expected -= double{responses[0][0][k]} * double{inputs[0][n - k]};
        }
        without_last = std::max(without_last, std::abs(double{outputs[0][n]} - expected));
    }
    CHECK(without_last > 10 * rounding);
}

TEST_CASE("The relative error of half precision is the same at any level of the response") {
    const ConvolutionShape shape{1, 1, 128, 12000, true};
    const float gain = GENERATE(1e-6F, 1.0F, 1e6F);
    const std::size_t samples = 24000;
    const Signals inputs = random_signals(1, samples, 3);
    Responses responses = random_responses(shape, shape.taps, 300);
    for (float& x : responses[0][0]) x *= gain;
    const ConvolutionFilter filter = make_filter(shape, responses);
    Convolver convolver(shape, 0);
    convolver.exchange(&filter);
    Signals outputs(1, Signal(samples));
    run(convolver, inputs, outputs, 0, samples, {128});
    CHECK(worst_error(outputs, direct(inputs, responses)) < kHalfRounding * double{gain});
}

TEST_CASE("Levels of partitions are contiguous and start at their earliest tap") {
    for (const std::size_t block : {1U, 16U, 100U, 128U, 256U, 480U, 1024U, 4096U, 8192U}) {
        for (const std::size_t taps : {1U, 100U, 5000U, 96000U, 480000U}) {
            for (const std::size_t outputs : {1U, 2U, 16U}) {
                const ConvolutionShape shape{1, outputs, block, taps};
                const std::vector<PartitionLevel> levels = partition_levels(shape);
                CAPTURE(block, taps, outputs, levels.size());
                CHECK(levels.size() <= kMaxLevels);
                CHECK(levels[0].size >= block);
                CHECK(levels[0].first_tap == 0);
                for (std::size_t l = 1; l < levels.size(); ++l) {
                    CHECK(levels[l].first_tap == levels[l - 1].end_tap());
                    CHECK(levels[l].first_tap == 2 * levels[l].size);
                    CHECK(levels[l].size % levels[l - 1].size == 0);
                    CHECK(levels[l].size <= 8192);
                }
                CHECK(levels.back().end_tap() >= taps);
                CHECK(levels.back().end_tap() < taps + levels.back().size);
            }
        }
    }
}

TEST_CASE("Exactly the partitions that changed are transformed") {
    const ConvolutionShape shape{2, 2, 128, 12000};
    const std::vector<PartitionLevel> levels = partition_levels(shape);
    REQUIRE(levels.size() == 3);
    FilterTransform transform(shape);
    std::vector<ConvolutionFilter> filters;
    while (filters.size() < 3) filters.emplace_back(shape);
    Responses responses = random_responses(shape, shape.taps, 400);
    fill(transform, responses, filters[0]);
    responses[1][0][5000] += 1;
    fill(transform, responses, filters[1]);
    responses[0][1].resize(9000);
    fill(transform, responses, filters[2]);
    for (std::size_t l = 0; l < levels.size(); ++l) {
        for (std::size_t i = 0; i < 2; ++i) {
            for (std::size_t p = 0; p < levels[l].count; ++p) {
                const std::size_t first = levels[l].first_tap + p * levels[l].size;
                const std::size_t end = first + levels[l].size;
                const auto same = [&](std::size_t a, std::size_t b) {
                    return filters[a].partitions(l, i)[p].spectra ==
                           filters[b].partitions(l, i)[p].spectra;
                };
                CAPTURE(l, i, p);
                CHECK(same(0, 1) == !(i == 1 && first <= 5000 && 5000 < end));
                CHECK(same(1, 2) == !(i == 0 && end > 9000));
            }
        }
    }
    // The spectra are correct.
    const Signals inputs = random_signals(2, 24000, 4);
    Convolver convolver(shape, 0);
    convolver.exchange(&filters[2]);
    Signals outputs(2, Signal(24000));
    run(convolver, inputs, outputs, 0, 24000, {128});
    CHECK(worst_error(outputs, direct(inputs, responses)) < kRounding);
}

TEST_CASE("Filters that are filled again reuse released memory") {
    const ConvolutionShape shape{1, 1, 64, 3000};
    FilterTransform transform(shape);
    std::vector<ConvolutionFilter> filters;
    while (filters.size() < 2) filters.emplace_back(shape);
    std::vector<const void*> seen;
    for (unsigned turn = 0; turn < 10; ++turn) {
        fill(transform, random_responses(shape, 3000, 500 + turn), filters[turn % 2]);
        const void* const spectra = filters[turn % 2].partitions(0, 0)[0].spectra;
        if (std::find(seen.begin(), seen.end(), spectra) == seen.end()) seen.push_back(spectra);
    }
    // One per filter, and one for the newest partitions of the transform.
    CHECK(seen.size() <= 3);
    CHECK(seen.size() >= 2);
}

TEST_CASE("Half precision holds the spectrum of any taps without overflow") {
    // A single tap of almost 1 at the start of a partition, and taps of one sign: bins have the sum
    // of all magnitudes, which is scaled to just below a power of two.
    for (const std::size_t taps : {1U, 1000U}) {
        const ConvolutionShape shape{1, 1, 128, 12000, true};
        Responses responses(1, Signals(1, Signal(shape.taps)));
        for (std::size_t k = 0; k < taps; ++k)
            responses[0][0][8192 + k] = 0.99999F / static_cast<float>(taps);
        const ConvolutionFilter filter = make_filter(shape, responses);
        Convolver convolver(shape, 0);
        convolver.exchange(&filter);
        const Signals inputs(1, Signal(16000, 1));
        Signals outputs(1, Signal(16000));
        run(convolver, inputs, outputs, 0, 16000, {128});
        CAPTURE(taps);
        CHECK(outputs[0].back() == Approx(1).epsilon(0x1p-10));  // rounding to 11 bits
        CHECK(worst_error(outputs, direct(inputs, responses)) < kHalfRounding);
    }
}

}  // namespace convolver_test
