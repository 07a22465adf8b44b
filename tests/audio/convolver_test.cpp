#include "audio/convolver.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include "tests/audio/signals.h"

using namespace aula;
using namespace aula::test;

namespace {

using Responses = std::vector<Signals>;  // [input][output]

/// Unrelated responses for each input and output, of unit energy each.
Responses random_responses(const ConvolutionShape& shape, std::size_t taps, unsigned seed) {
    Responses responses;
    for (std::size_t i = 0; i < shape.inputs; ++i) {
        responses.push_back(random_signals(shape.outputs, taps, seed + static_cast<unsigned>(i)));
        for (Signal& response : responses.back()) {
            for (float& x : response) x /= std::sqrt(static_cast<float>(taps));
        }
    }
    return responses;
}

ConvolutionFilter make_filter(const ConvolutionShape& shape, const Responses& responses) {
    FilterTransform transform(shape);
    ConvolutionFilter filter(shape);
    for (std::size_t i = 0; i < shape.inputs; ++i) {
        const std::vector<std::span<const float>> views(responses[i].begin(), responses[i].end());
        transform.transform(views, i, filter);
    }
    return filter;
}

/// The convolution as it is defined, in double precision: [output][sample].
std::vector<std::vector<double>> direct(const Signals& inputs, const Responses& responses) {
    const std::size_t samples = inputs[0].size();
    std::vector<std::vector<double>> outputs(responses[0].size(), std::vector<double>(samples));
    for (std::size_t i = 0; i < inputs.size(); ++i) {
        for (std::size_t o = 0; o < outputs.size(); ++o) {
            const Signal& h = responses[i][o];
            for (std::size_t n = 0; n < samples; ++n) {
                double sum = 0;
                for (std::size_t k = 0; k < std::min(h.size(), n + 1); ++k) {
                    sum += double{h[k]} * double{inputs[i][n - k]};
                }
                outputs[o][n] += sum;
            }
        }
    }
    return outputs;
}

/// Calls the convolver from sample `first` to `last`, with calls of the given sizes in turn.
void run(Convolver& convolver, const Signals& inputs, Signals& outputs, std::size_t first,
         std::size_t last, const std::vector<std::size_t>& calls) {
    for (std::size_t turn = 0; first < last; ++turn) {
        const std::size_t samples = std::min(calls[turn % calls.size()], last - first);
        std::vector<const float*> in;
        std::vector<float*> out;
        for (const Signal& signal : inputs) in.push_back(signal.data() + first);
        for (Signal& signal : outputs) out.push_back(signal.data() + first);
        convolver.process(in, out, samples);
        first += samples;
    }
}

double worst_error(const Signals& outputs, const std::vector<std::vector<double>>& expected) {
    double worst = 0;
    for (std::size_t o = 0; o < outputs.size(); ++o) {
        for (std::size_t n = 0; n < outputs[o].size(); ++n) {
            worst = std::max(worst, std::abs(double{outputs[o][n]} - expected[o][n]));
        }
    }
    return worst;
}

// Rounding: outputs are of the order of 1 to 4 (unit energy in, unit energy responses, up to 3
// inputs); the transforms and sums add some 20 roundings of 2^-24 each of a bin's size: 1e-5 is 5
// times what is seen.
constexpr double kRounding = 1e-5;

}  // namespace

TEST_CASE("Convolution agrees with its definition for any shape and any size of calls") {
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

TEST_CASE("Before the first filter the output is zero, after it the whole history is heard") {
    const ConvolutionShape shape{1, 1, 64, 500};
    const Signals inputs = random_signals(1, 2000, 2);
    const Responses responses = random_responses(shape, 500, 200);
    const ConvolutionFilter filter = make_filter(shape, responses);
    Convolver convolver(shape, 512);
    Signals outputs(1, Signal(2000));
    run(convolver, inputs, outputs, 0, 700, {64, 13});
    CHECK(outputs[0] == Signal(2000));
    convolver.exchange(&filter);
    CHECK_FALSE(convolver.fading());
    run(convolver, inputs, outputs, 700, 2000, {64, 13});
    auto expected = direct(inputs, responses);
    std::fill_n(expected[0].begin(), 700, 0.0);
    CHECK(worst_error(outputs, expected) < kRounding);
}

TEST_CASE("An exchange is the old convolution fading out plus the new one fading in") {
    const ConvolutionShape shape{2, 2, 64, 900};
    const std::vector<std::size_t> calls =
        GENERATE(std::vector<std::size_t>{64}, std::vector<std::size_t>{50, 64, 3});
    const std::size_t fade = 512;
    // At a boundary of partitions and within one.
    const std::size_t at = GENERATE(640U, 1000U);
    const Signals inputs = random_signals(2, 3000, 3);
    const Responses before = random_responses(shape, 900, 300);
    const Responses after = random_responses(shape, 400, 400);
    const ConvolutionFilter filter_before = make_filter(shape, before);
    const ConvolutionFilter filter_after = make_filter(shape, after);
    Convolver convolver(shape, fade);
    convolver.exchange(&filter_before);
    Signals outputs(2, Signal(3000));
    run(convolver, inputs, outputs, 0, at, calls);
    convolver.exchange(&filter_after);
    CHECK(convolver.fading());
    run(convolver, inputs, outputs, at, 3000, calls);
    CHECK_FALSE(convolver.fading());

    auto expected = direct(inputs, before);
    const auto faded_in = direct(inputs, after);
    for (std::size_t o = 0; o < 2; ++o) {
        for (std::size_t n = at; n < 3000; ++n) {
            const double position = (static_cast<double>(n - at) + 0.5) / static_cast<double>(fade);
            const double weight = 0.5 - 0.5 * std::cos(std::numbers::pi * std::min(position, 1.0));
            expected[o][n] += weight * (faded_in[o][n] - expected[o][n]);
        }
    }
    CHECK(worst_error(outputs, expected) < kRounding);
}

TEST_CASE("A steady sine through exchanged filters has its closed form") {
    const ConvolutionShape shape{1, 1, 128, 4000};
    const std::size_t fade = 1024;
    const std::size_t samples = 24000;
    const double omega = 2 * std::numbers::pi * 1000 / 48000;
    Signals inputs(1, Signal(samples));
    for (std::size_t n = 0; n < samples; ++n) {
        inputs[0][n] = static_cast<float>(std::sin(omega * static_cast<double>(n)));
    }
    // Unrelated responses, exchanged every 1600 samples once the tone is steady.
    std::vector<ConvolutionFilter> filters;
    std::vector<std::complex<double>> gains;
    for (unsigned k = 0; k < 11; ++k) {
        const Responses responses = random_responses(shape, 4000, 500 + k);
        filters.push_back(make_filter(shape, responses));
        std::complex<double> gain = 0;
        for (std::size_t j = 0; j < 4000; ++j) {
            gain += double{responses[0][0][j]} * std::polar(1.0, -omega * static_cast<double>(j));
        }
        gains.push_back(gain);
    }
    Convolver convolver(shape, fade);
    Signals outputs(1, Signal(samples));
    const std::size_t start = 6400;
    convolver.exchange(&filters[0]);
    run(convolver, inputs, outputs, 0, start, {128});
    for (std::size_t k = 1; k < filters.size(); ++k) {
        convolver.exchange(&filters[k]);
        run(convolver, inputs, outputs, start + (k - 1) * 1600, start + k * 1600, {128});
    }
    const std::vector<float> weights = raised_cosine(fade);
    double worst = 0;
    for (std::size_t n = start; n < start + 16000; ++n) {
        const std::size_t k = (n - start) / 1600;
        const std::size_t position = (n - start) % 1600;
        const double w = position < fade ? double{weights[position]} : 1.0;
        const std::complex<double> gain = (1 - w) * gains[k] + w * gains[k + 1];
        const double expected = std::imag(gain * std::polar(1.0, omega * static_cast<double>(n)));
        worst = std::max(worst, std::abs(double{outputs[0][n]} - expected));
    }
    // -100 dB of the tone, which has unit amplitude and gains of the order of 1.
    CHECK(worst < 1e-5);
}

TEST_CASE("The weights of a crossfade add up to one") {
    const std::vector<float> weights = raised_cosine(1024);
    for (std::size_t n = 0; n < 1024; ++n) {
        CHECK(weights[n] + weights[1023 - n] == Approx(1).margin(1e-7));
    }
    CHECK(std::is_sorted(weights.begin(), weights.end()));
}
