#include "audio/render/early_filters.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "audio/dsp/band_filter.h"

namespace early_filters_test {

using namespace aula;

namespace {

constexpr double kRate_hz = 48000;
constexpr std::size_t kTaps = 1024;
constexpr std::size_t kMargin = 31;

// Of a hard wall, a curtain and a bass trap.
constexpr std::array<std::array<float, 8>, 3> kGains{
    {{0.98F, 0.981F, 0.976F, 0.97F, 0.953F, 0.94F, 0.87F, 0.6F},
     {0.96F, 0.93F, 0.81F, 0.62F, 0.53F, 0.51F, 0.43F, 0.31F},
     {0.2F, 0.31F, 0.63F, 0.95F, 0.97F, 0.97F, 0.97F, 0.9F}}};

/// About that of air at 20 degrees and 50 % above 1 kHz.
double air(double frequency_hz) { return 3e-10 * frequency_hz * frequency_hz; }

/// The energy of the difference between a kept filter and the design of other gains, re the design.
double difference_db(std::span<const float> kept, const std::array<float, 8>& gains,
                     double length_m) {
    BandFilterDesigner designer(kRate_hz, kTaps, air);
    std::vector<float> exact(kTaps);
    designer.design(gains, length_m, exact);
    const float greatest = *std::max_element(gains.begin(), gains.end());
    double energy = 0, difference = 0;
    for (std::size_t n = 0; n < kTaps; ++n) {
        const std::size_t at = kMargin + n;
        const float x = at < kept.size() ? greatest * kept[at] : 0;
        energy += double{exact[n]} * double{exact[n]};
        difference += (double{x} - double{exact[n]}) * (double{x} - double{exact[n]});
    }
    return 10 * std::log10(difference / energy);
}

std::vector<float> copy(std::span<const float> of) { return {of.begin(), of.end()}; }

}  // namespace

TEST_CASE("The filters of early paths are within -45 dB of those of their gains") {
    BandFilterDesigner designer(kRate_hz, kTaps, air);
    EarlyFilters filters(designer, true, kMargin, 1);
    for (const std::array<float, 8>& gains : kGains) {
        for (const double length_m : {3.1, 17.37, 211.1}) {
            const std::span<const float> filter = filters.filter(0, gains, length_m);
            CAPTURE(gains[0], length_m);
            CHECK(difference_db(filter, gains, length_m) < -45);
            CHECK(filter.size() <= kMargin + kTaps + kMargin);
            CHECK(std::all_of(filter.begin(), filter.begin() + kMargin,
                              [](float x) { return x == 0; }));
            CHECK(
                std::all_of(filter.end() - kMargin, filter.end(), [](float x) { return x == 0; }));
            // Companion: half a decibel in one octave.
            std::array<float, 8> other = gains;
            other[4] *= 1.06F;
            CHECK(difference_db(filter, other, length_m) > -40);
        }
    }
}

TEST_CASE("A filter of an early path does not depend on those that are kept") {
    BandFilterDesigner designer(kRate_hz, kTaps, air);
    EarlyFilters filters(designer, true, kMargin, 2);
    const auto first = copy(filters.filter(0, kGains[0], 17.37));
    CHECK(first.size() < kMargin + kTaps * 2 / 3 + kMargin);
    // A decimetre farther, of other strength, of another source, after other paths and frames.
    std::array<float, 8> weaker = kGains[0];
    for (float& gain : weaker) gain *= 0.37F;
    const float* const kept = filters.filter(0, kGains[0], 17.3).data();
    CHECK(filters.filter(0, weaker, 17.33).data() == kept);
    CHECK(copy(filters.filter(1, kGains[0], 17.37)) == first);
    for (int frame = 0; frame < 3; ++frame) {
        filters.next_frame(0);
        filters.filter(0, kGains[1], 17.37);
        if (frame == 0) CHECK(filters.filter(0, kGains[0], 17.37).data() == kept);
    }
    CHECK(copy(filters.filter(0, kGains[0], 17.37)) == first);
    // But on each gain, and on the length.
    CHECK(copy(filters.filter(0, kGains[0], 18)) != first);
    for (std::size_t b = 0; b < kGains[0].size(); ++b) {
        CAPTURE(b);
        std::array<float, 8> other = kGains[0];
        other[b] *= 0.94F;
        CHECK(copy(filters.filter(0, other, 17.37)) != first);
    }
    // Without air there is no loss over a length.
    BandFilterDesigner of_vacuum(kRate_hz, kTaps);
    EarlyFilters vacuum(of_vacuum, false, kMargin, 1);
    CHECK(vacuum.filter(0, kGains[0], 18).data() == vacuum.filter(0, kGains[0], 400).data());
}

}  // namespace early_filters_test
