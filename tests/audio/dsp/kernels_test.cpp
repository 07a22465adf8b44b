#include "audio/dsp/kernels.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

TEST_CASE("A filter of any length gives any number of samples") {
    constexpr std::size_t kMaxTaps = 384;
    std::vector<float> x(kMaxTaps + 200);
    std::vector<float> h(kMaxTaps);
    for (std::size_t i = 0; i < x.size(); ++i) x[i] = std::sin(static_cast<float>(i * i % 101));
    for (std::size_t i = 0; i < h.size(); ++i) h[i] = std::cos(static_cast<float>(i * 7 % 53));
    for (const std::size_t taps : {1U, 2U, 15U, 16U, 17U, 32U, 255U, 256U, 384U}) {
        for (const std::size_t samples : {1U, 2U, 15U, 16U, 17U, 63U, 64U, 65U, 100U, 150U}) {
            std::vector<float> out(samples + 1, 77.0F);
            const float* const now = x.data() + kMaxTaps;
            aula::filter(now, h.data(), taps, out.data(), samples);
            double worst = 0;
            for (std::size_t n = 0; n < samples; ++n) {
                double sum = 0;
                for (std::size_t k = 0; k < taps; ++k)
                    sum += static_cast<double>(h[k]) * static_cast<double>(x[kMaxTaps + n - k]);
                worst = std::max(worst, std::abs(sum - static_cast<double>(out[n])));
            }
            CAPTURE(taps, samples);
            // Rounding: as many sums of products below 1 as there are taps, 6e-8 each.
            CHECK(worst < 6e-8 * static_cast<double>(taps) * 8);
            CHECK(out[samples] == 77.0F);
        }
    }
}
