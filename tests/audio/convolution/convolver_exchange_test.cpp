#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <limits>
#include <memory>
#include <numbers>
#include <vector>

#include "audio/dsp/fade.h"
#include "aula/audio/convolver.h"
#include "tests/audio/convolution/convolution.h"

using namespace aula;
using namespace aula::test;

namespace {

constexpr std::size_t kFade = 512;

// Rounding, as in convolver_test.cpp.
constexpr double kRounding = 1e-5;

}  // namespace

TEST_CASE("The output is zero before the first filter and then fades in from silence") {
    const ConvolutionShape shape{1, 1, 64, 500};
    const std::vector<PartitionLevel> levels = partition_levels(shape);
    const Signals inputs = random_signals(1, 4000, 2);
    const Responses responses = random_responses(shape, 500, 200);
    const ConvolutionFilter filter = make_filter(shape, responses);
    Convolver convolver(shape, kFade);
    Signals outputs(1, Signal(4000));
    run(convolver, inputs, outputs, 0, 700, {64, 13});
    CHECK(outputs[0] == Signal(4000));
    convolver.exchange(&filter);
    CHECK(convolver.fading());
    run(convolver, inputs, outputs, 700, 4000, {64, 13});
    ExactSignals expected{std::vector<double>(4000)};
    const ExchangePlan plan(levels, kFade, {0, 700});
    for (std::size_t l = 0; l < levels.size(); ++l) {
        const ExactSignals part =
            direct(inputs, part_of(responses, levels[l].first_tap, levels[l].end_tap()));
        for (std::size_t n = 0; n < 4000; ++n) {
            expected[0][n] += plan.weight(l, 1, n) * part[0][n];
        }
    }
    CHECK(worst_error(outputs, expected) < kRounding);
}

TEST_CASE("An exchange crossfades from the old convolution to the new one, level by level") {
    const ConvolutionShape shape{2, 2, 64, 9000};
    const std::vector<PartitionLevel> levels = partition_levels(shape);
    REQUIRE(levels.size() == 3);
    const std::vector<std::size_t> calls =
        GENERATE(std::vector<std::size_t>{64}, std::vector<std::size_t>{50, 64, 3});
    // At boundaries of partitions and within them; the last level skips some.
    const std::vector<std::size_t> at{0, 5120, 5700, 6800, 8000, 12288, 13000};
    const std::size_t samples = 24000;
    const Signals inputs = random_signals(2, samples, 3);
    std::vector<Responses> responses;
    std::vector<ConvolutionFilter> filters;
    FilterTransform transform(shape);
    for (unsigned k = 0; k < at.size(); ++k) {
        responses.push_back(random_responses(shape, k % 2 == 0 ? 9000 : 4000, 300 + 10 * k));
        // Partitions that do not change are not faded; the result is the same.
        if (k == 3) {
            responses[3] = responses[2];
            for (float& x : responses[3][0][1]) x = -x;
        }
        filters.emplace_back(shape);
        fill(transform, responses[k], filters[k]);
    }
    Convolver convolver(shape, kFade);
    Signals outputs(2, Signal(samples));
    for (std::size_t k = 0; k < at.size(); ++k) {
        convolver.exchange(&filters[k]);
        run(convolver, inputs, outputs, at[k], k + 1 < at.size() ? at[k + 1] : samples, calls);
    }
    CHECK_FALSE(convolver.fading());

    // Expected output of the plan, and of exchanges without a fade.
    const ExchangePlan plan(levels, kFade, at);
    const ExchangePlan hard(levels, 0, at);
    ExactSignals expected(2, std::vector<double>(samples));
    ExactSignals swapped = expected;
    for (std::size_t l = 0; l < levels.size(); ++l) {
        for (std::size_t k = 0; k < at.size(); ++k) {
            const ExactSignals part =
                direct(inputs, part_of(responses[k], levels[l].first_tap, levels[l].end_tap()));
            for (std::size_t o = 0; o < 2; ++o) {
                for (std::size_t n = 0; n < samples; ++n) {
                    expected[o][n] += plan.weight(l, k, n) * part[o][n];
                    swapped[o][n] += hard.weight(l, k, n) * part[o][n];
                }
            }
        }
    }
    CHECK(worst_error(outputs, expected) < kRounding);
    CHECK(worst_error(outputs, swapped) > 0.1);
}

TEST_CASE("A filter is used until every level has released it and uses a newer one") {
    const ConvolutionShape shape{1, 1, 128, 20000};
    const std::vector<PartitionLevel> levels = partition_levels(shape);
    REQUIRE(levels.size() == 3);
    const std::size_t longest = levels.back().size;
    std::vector<ConvolutionFilter> filters;
    for (unsigned k = 0; k < 12; ++k) {
        filters.push_back(make_filter(shape, random_responses(shape, 20000, 600 + k)));
    }
    Convolver convolver(shape, kFade);
    const Signals inputs = random_signals(1, 64000, 5);
    Signals outputs(1, Signal(64000));
    std::size_t now = 0;
    std::size_t max = 0;
    for (const ConvolutionFilter& filter : filters) {
        convolver.exchange(&filter);
        for (std::size_t i = 0; i < kFade / 128; ++i, now += 128) {
            run(convolver, inputs, outputs, now, now + 128, {128});
            const auto used = [&](const ConvolutionFilter& f) { return convolver.uses(&f); };
            max = std::max(
                max, static_cast<std::size_t>(std::count_if(filters.begin(), filters.end(), used)));
        }
    }
    CHECK(max > 2);
    CHECK(max <= convolver.max_filters());
    // The last level takes the filter within a segment and computes with it in the next one.
    const std::size_t finished = (now / longest + 3) * longest;
    run(convolver, inputs, outputs, now, finished, {128});
    for (std::size_t k = 0; k < filters.size(); ++k) {
        CAPTURE(k);
        CHECK(convolver.uses(&filters[k]) == (k + 1 == filters.size()));
    }
    run(convolver, inputs, outputs, finished, 64000, {128});
    const ExactSignals expected = direct(inputs, random_responses(shape, 20000, 611));
    double worst = 0;
    for (std::size_t n = finished + longest; n < 64000; ++n) {
        worst = std::max(worst, std::abs(double{outputs[0][n]} - expected[0][n]));
    }
    CHECK(worst < kRounding);
}

TEST_CASE("A convolver uses at most the stated number of filters at a time, and reaches it") {
    // Each of four levels uses two in one blend, or in two, if its partitions are much longer than
    // those of the level before and filters are exchanged as fast as the first level allows.
    const ConvolutionShape shape{1, 1, 16, 192000};
    const std::vector<PartitionLevel> levels = partition_levels(shape);
    REQUIRE(levels.size() == kMaxLevels);
    constexpr std::size_t kShortFade = 16;
    std::vector<ConvolutionFilter> filters;
    FilterTransform transform(shape);
    // Filters are distinguished by their addresses; their content does not matter.
    for (std::size_t k = 0; k < 4096; ++k) filters.emplace_back(shape);
    Convolver convolver(shape, kShortFade);
    const Signals inputs(1, Signal(16));
    Signals outputs(1, Signal(16));
    std::vector<const ConvolutionFilter*> used;
    std::size_t max = 0;
    for (const ConvolutionFilter& filter : filters) {
        convolver.exchange(&filter);
        used.push_back(&filter);
        max = std::max(max, used.size());
        do {
            run(convolver, inputs, outputs, 0, 16, {16});
            std::erase_if(used, [&](const auto* f) { return !convolver.uses(f); });
        } while (convolver.fading());
    }
    const auto blending = static_cast<std::size_t>(
        std::count_if(levels.begin(), levels.end(), [](const auto& l) { return l.blends(); }));
    CHECK(blending < kMaxLevels);
    CHECK(convolver.max_filters() == 2 * kMaxLevels + 2 * (blending - 1));
    CHECK(max == convolver.max_filters());
}

TEST_CASE("The weights of a crossfade sum to one") {
    const std::vector<float> weights = raised_cosine(1024);
    for (std::size_t n = 0; n < 1024; ++n) {
        CHECK(weights[n] + weights[1023 - n] == Approx(1).margin(1e-7));
    }
    CHECK(std::is_sorted(weights.begin(), weights.end()));
}

TEST_CASE("After an exchange to silence every level is silent") {
    const ConvolutionShape shape{2, 2, 64, 9000};
    const std::vector<PartitionLevel> levels = partition_levels(shape);
    REQUIRE(levels.size() == 3);
    const std::size_t samples = 40000;
    const Signals inputs = random_signals(2, samples, 7);
    const ConvolutionFilter sounding = make_filter(shape, random_responses(shape, 9000, 700));
    // The shorter filter after the exchange has no taps, or taps in the first level only.
    const std::size_t taps = GENERATE(std::size_t{0}, std::size_t{50});
    const Responses brief = random_responses(shape, taps, 800);
    const ConvolutionFilter after = make_filter(shape, brief);
    Convolver convolver(shape, kFade);
    Signals outputs(2, Signal(samples));
    convolver.exchange(&sounding);
    run(convolver, inputs, outputs, 0, 15000, {64});
    convolver.exchange(&after);
    run(convolver, inputs, outputs, 15000, samples, {64});
    // The last level takes the filter within a segment, computes with it in the next one and fades
    // in the one after that.
    const std::size_t silent = 15000 + 4 * levels.back().size;
    REQUIRE(silent + 8 * levels.back().size < samples);
    const ExactSignals expected = direct(inputs, brief);
    double worst = 0;
    for (std::size_t o = 0; o < 2; ++o) {
        for (std::size_t n = silent; n < samples; ++n) {
            worst = std::max(worst, std::abs(double{outputs[o][n]} - expected[o][n]));
        }
    }
    CHECK(worst < (taps == 0 ? 1e-30 : kRounding));
}

TEST_CASE("A released filter is not read, even if the exchange ends within a partition") {
    const ConvolutionShape shape{1, 1, 64, 128};
    REQUIRE(partition_levels(shape).size() == 1);
    // The exchange ends in the middle of a partition.
    constexpr std::size_t kFadeToMiddle = 96;
    constexpr std::size_t kExchange = 640;
    constexpr std::size_t kSamples = 1280;
    const Signals inputs = random_signals(1, kSamples, 7);
    FilterTransform transform(shape);
    std::vector<ConvolutionFilter> filters;
    while (filters.size() < 2) filters.emplace_back(shape);
    fill(transform, random_responses(shape, 128, 700), filters[0]);
    const Responses later = random_responses(shape, 128, 701);
    fill(transform, later, filters[1]);

    Convolver convolver(shape, kFadeToMiddle);
    Signals outputs(1, Signal(kSamples));
    convolver.exchange(&filters[0]);
    run(convolver, inputs, outputs, 0, kExchange, {32});
    convolver.exchange(&filters[1]);
    std::size_t now = kExchange;
    for (; convolver.uses(&filters[0]); now += 32)
        run(convolver, inputs, outputs, now, now + 32, {32});
    CHECK(now == kExchange + kFadeToMiddle);
    // Its memory is reused.
    fill(transform, {{Signal(128, std::numeric_limits<float>::quiet_NaN())}}, filters[0]);
    run(convolver, inputs, outputs, now, kSamples, {32});
    const ExactSignals expected = direct(inputs, later);
    double worst = 0;
    for (std::size_t n = now; n < kSamples; ++n) {
        REQUIRE(std::isfinite(outputs[0][n]));
        worst = std::max(worst, std::abs(double{outputs[0][n]} - expected[0][n]));
    }
    CHECK(worst < kRounding);
}

TEST_CASE("Levels that take no filter keep their partitions, and released ones return theirs") {
    const ConvolutionShape shape{1, 2, 64, 20000};
    const std::vector<PartitionLevel> levels = partition_levels(shape);
    REQUIRE(levels.size() == 3);
    constexpr std::size_t kExchanges = 60;
    constexpr std::size_t kPeriod = 700;
    const Signals inputs = random_signals(1, kExchanges * kPeriod, 8);
    const auto responses_of = [&](std::size_t k) {
        return random_responses(shape, 20000, 800 + static_cast<unsigned>(k));
    };

    // Every filter is whole and lives to the end.
    FilterTransform whole_transform(shape);
    std::vector<ConvolutionFilter> whole;
    whole.reserve(kExchanges);
    Convolver whole_convolver(shape, kFade);
    Signals expected(2, Signal(inputs[0].size()));
    for (std::size_t k = 0; k < kExchanges; ++k) {
        fill(whole_transform, responses_of(k), whole.emplace_back(shape));
        whole_convolver.exchange(&whole.back());
        run(whole_convolver, inputs, expected, k * kPeriod, (k + 1) * kPeriod, {64, 23});
    }

    FilterTransform transform(shape);
    std::vector<std::unique_ptr<ConvolutionFilter>> held;
    Convolver convolver(shape, kFade);
    Signals outputs = expected;
    std::size_t left_out = 0;
    for (std::size_t k = 0; k < kExchanges; ++k) {
        const std::vector<char> used =
            levels_in_use(shape, kFade, static_cast<std::int64_t>(k * kPeriod),
                          static_cast<std::int64_t>((k + 1) * kPeriod));
        REQUIRE(used.size() == levels.size());
        left_out += used.back() == 0 ? 1 : 0;
        held.push_back(std::make_unique<ConvolutionFilter>(shape));
        const Responses responses = responses_of(k);
        const std::vector<std::span<const float>> views(responses[0].begin(), responses[0].end());
        transform.transform(views, 0, *held.back(), used);
        convolver.exchange(held.back().get());
        for (Signal& output : outputs)
            std::fill_n(output.begin() + static_cast<std::ptrdiff_t>(k * kPeriod), kPeriod, 0.0F);
        run(convolver, inputs, outputs, k * kPeriod, (k + 1) * kPeriod, {64, 23});
        for (const auto& filter : held) convolver.release_unused(filter.get());
        std::erase_if(held, [&](const auto& filter) { return !convolver.uses(filter.get()); });
    }
    CHECK(outputs == expected);
    CHECK(left_out > kExchanges / 3);

    // Spectra of a filter's partitions have twice as many numbers as taps. A level has the filters
    // of the exchanges at both ends of a segment and those of the present exchange, and all but the
    // last one those that are exchanged within two segments.
    const auto bytes = [&](const PartitionLevel& level) {
        return 2 * sizeof(float) * level.count * level.size * shape.outputs;
    };
    std::size_t limit = 6 * bytes(levels.back());
    for (std::size_t l = 0; l + 1 < levels.size(); ++l)
        limit += (6 + (2 * levels[l].size + kPeriod - 1) / kPeriod) * bytes(levels[l]);
    CHECK(transform.memory_bytes() <= limit);
    CHECK(transform.memory_bytes() >= bytes(levels.back()));
}
