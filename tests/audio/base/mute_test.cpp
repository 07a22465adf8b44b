#include "audio/base/mute.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <vector>

using namespace aula;

namespace {

using Limits = std::numeric_limits<float>;

}  // namespace

TEST_CASE("Muting keeps samples up to the largest magnitude to the bit") {
    const std::vector<float> samples{0.0F, -0.0F, 1.0F, -1.0F, 0.999F, Limits::denorm_min(), -0.3F};
    std::vector<float> muted = samples;
    CHECK(mute_beyond(1, muted) == 0);
    CHECK(muted == samples);
    CHECK(std::signbit(muted[1]));
}

TEST_CASE("Muting replaces each sample beyond the largest magnitude by zero and counts it") {
    std::vector<float> samples{std::nextafter(1.0F, 2.0F), 0.5F, -std::nextafter(1.0F, 2.0F),
                               Limits::infinity(),         1.0F, -Limits::infinity(),
                               Limits::quiet_NaN(),        0.25F};
    CHECK(mute_beyond(1, samples) == 5);
    CHECK(samples == std::vector<float>{0, 0.5F, 0, 0, 1, 0, 0, 0.25F});
    CHECK(mute_beyond(1, samples) == 0);
}

TEST_CASE("Samples are within a magnitude if none of them would be muted") {
    const std::vector<float> samples{0.0F, -1.0F, 1.0F, 0.5F};
    CHECK(all_within(1, samples));
    CHECK(all_within(1, {}));
    for (const float bad : {std::nextafter(1.0F, 2.0F), -Limits::infinity(), Limits::quiet_NaN()}) {
        for (std::size_t at = 0; at < samples.size(); ++at) {
            std::vector<float> changed = samples;
            changed[at] = bad;
            CHECK_FALSE(all_within(1, changed));
        }
    }
}

TEST_CASE("With the largest float only samples that are not finite are muted") {
    std::vector<float> samples{Limits::max(), -Limits::max(), Limits::infinity(),
                               -Limits::quiet_NaN()};
    CHECK(mute_beyond(Limits::max(), samples) == 2);
    CHECK(samples == std::vector<float>{Limits::max(), -Limits::max(), 0, 0});
    CHECK(mute_beyond(1, {}) == 0);
}
