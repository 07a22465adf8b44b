#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include "aula/audio/convolver.h"
#include "tests/audio/convolution/convolution.h"

namespace convolver_sine_test {

using namespace aula;
using namespace aula::test;

namespace {

constexpr double kRate_hz = 48000;
constexpr double kTone_hz = 1000;
constexpr double kOmega = 2 * std::numbers::pi * kTone_hz / kRate_hz;
constexpr std::size_t kFade = 512;

/// A tone through independent random filters that are exchanged at regular intervals once the
/// output is steady.
struct ToneThroughExchanges {
    ConvolutionShape shape;
    std::vector<PartitionLevel> levels;
    std::vector<std::size_t> exchanges{0};                 ///< samples
    std::vector<std::vector<std::complex<double>>> gains;  ///< [filter][level] at the tone
    std::size_t samples;
    Signal output;

    ToneThroughExchanges(const ConvolutionShape& wanted, std::size_t count, std::size_t interval,
                         std::size_t fade)
        : shape(wanted), levels(partition_levels(wanted)) {
        // A multiple of the block: exchanges occur between calls.
        const std::size_t start = (levels.back().end_tap() + 2 * levels.back().size);
        for (std::size_t k = 0; k < count; ++k) exchanges.push_back(start + k * interval);
        samples = exchanges.back() + interval;
        std::vector<ConvolutionFilter> filters;
        for (unsigned k = 0; k < exchanges.size(); ++k) {
            const Responses responses = random_responses(shape, shape.taps, 500 + k);
            filters.push_back(make_filter(shape, responses));
            gains.emplace_back();
            for (const PartitionLevel& level : levels) {
                std::complex<double> gain = 0;
                for (std::size_t j = level.first_tap; j < std::min(level.end_tap(), shape.taps);
                     ++j) {
                    gain += double{responses[0][0][j]} *
                            std::polar(1.0, -kOmega * static_cast<double>(j));
                }
                gains.back().push_back(gain);
            }
        }
        const Signals inputs{sine(kTone_hz, samples, kRate_hz)};
        Signals outputs(1, Signal(samples));
        Convolver convolver(shape, fade);
        for (std::size_t k = 0; k < exchanges.size(); ++k) {
            convolver.exchange(&filters[k]);
            const std::size_t end = k + 1 < exchanges.size() ? exchanges[k + 1] : samples;
            run(convolver, inputs, outputs, exchanges[k], end, {shape.block});
        }
        output = outputs[0];
    }

    std::size_t steady() const { return exchanges[1]; }

    /// y[n] = Im(e^(i w n) sum over levels g and filters k of w_gk[n] H_gk(w)).
    double exact(const ExchangePlan& plan, std::size_t n) const {
        std::complex<double> gain = 0;
        for (std::size_t k = 0; k < exchanges.size(); ++k) {
            for (std::size_t l = 0; l < levels.size(); ++l) {
                const double weight = plan.weight(l, k, n);
                if (weight != 0) gain += weight * gains[k][l];
            }
        }
        return std::imag(gain * std::polar(1.0, kOmega * static_cast<double>(n)));
    }

    /// The difference from the output that `plan` predicts: RMS re RMS, and peak re peak.
    struct Error {
        double rms = 0;
        double worst = 0;
    };
    Error error(const ExchangePlan& plan) const {
        double energy = 0;
        double largest = 0;
        Error found;
        for (std::size_t n = steady(); n < samples; ++n) {
            const double expected = exact(plan, n);
            const double difference = std::abs(double{output[n]} - expected);
            found.rms += difference * difference;
            found.worst = std::max(found.worst, difference);
            energy += expected * expected;
            largest = std::max(largest, std::abs(expected));
        }
        return {std::sqrt(found.rms / energy), found.worst / largest};
    }

    /// The output from the first exchange on, as computed or as `plan` predicts it.
    Signal exchanged_output() const {
        return {output.begin() + static_cast<std::ptrdiff_t>(steady()), output.end()};
    }
    Signal exchanged_output(const ExchangePlan& plan) const {
        Signal signal;
        for (std::size_t n = steady(); n < samples; ++n) {
            signal.push_back(static_cast<float>(exact(plan, n)));
        }
        return signal;
    }
};

}  // namespace

TEST_CASE("A steady sine through exchanged filters agrees with the closed form") {
    const bool half = GENERATE(false, true);
    // About 30 exchanges per second.
    const ToneThroughExchanges tone({1, 1, 128, 20000, half}, 11, 1664, kFade);
    REQUIRE(tone.levels.size() == 3);
    const auto error = tone.error({tone.levels, kFade, tone.exchanges});
    CAPTURE(half, error.rms, error.worst);
    // Rounding: -100 dB in single precision, at every sample. Half-precision spectra have an RMS
    // error of 2.1e-4 of their magnitude, -74 dB: -70 dB in RMS, four times as much at the worst
    // sample.
    CHECK(error.rms < (half ? 3.16e-4 : 1e-5));
    CHECK(error.worst < (half ? 8.4e-4 : 1e-5));
    // Companions: a fade longer by 3 %; the head's weights at all levels.
    CHECK(tone.error({tone.levels, kFade + 16, tone.exchanges}).worst > 1e-3);
    const std::vector<PartitionLevel> heads(tone.levels.size(), tone.levels[0]);
    CHECK(tone.error({heads, kFade, tone.exchanges}).rms > 1e-3);
}

TEST_CASE("Exchanges of unrelated filters at 50 Hz do not click") {
    const bool half = GENERATE(false, true);
    const ToneThroughExchanges tone({1, 1, 64, 20000, half}, 50, 960, 960);
    // A fade of 960 samples broadens the tone by less than this; clicks are broadband.
    constexpr double kNear_hz = 2000;
    const auto spread_db = [](const Signal& signal) {
        return energy_outside_db(signal, kTone_hz, kNear_hz, kRate_hz);
    };
    const auto residual_db = [](const Signal& signal) {
        return peak_outside_db(signal, kTone_hz, kNear_hz, kRate_hz);
    };
    const Signal output = tone.exchanged_output();
    CAPTURE(half, spread_db(output), residual_db(output));
    CHECK(spread_db(output) < -79);
    CHECK(residual_db(output) < -60);
    // Companions: the head exchanges without a fade, and with one of a quarter of a block.
    for (const std::size_t fade : {0U, 16U}) {
        const Signal clicking = tone.exchanged_output({tone.levels, fade, tone.exchanges});
        CAPTURE(fade, spread_db(clicking), residual_db(clicking));
        CHECK(spread_db(clicking) > -79);
        CHECK(residual_db(clicking) > -60);
    }
    // The measurement has a lower floor.
    CHECK(spread_db(sine(kTone_hz, output.size(), kRate_hz)) < -110);
}

}  // namespace convolver_sine_test
