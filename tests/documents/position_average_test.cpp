#include "apps/documents/position_average.h"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>

#include "engine/rays/room_survey.h"

using namespace aula;

TEST_CASE("Values are averaged over positions with the deviation of the sample") {
    constexpr auto kT30 = static_cast<std::size_t>(AcousticParameter::t30);
    std::array<PairParameters, 3> pairs;
    pairs[0].octaves[kT30][4] = {1.0, 0.03};
    pairs[1].octaves[kT30][4] = {1.2, 0.04};
    pairs[0].broadband[kT30] = {2.0, {}};
    pairs[1].sti = {0.5, 0.1};
    const std::array<const PairParameters*, 3> all{&pairs[0], &pairs[1], &pairs[2]};
    const PositionAverage average = average_over_positions(all);
    CHECK(average.positions == 3);
    // The third pair has no value.
    CHECK(*average.mean.octaves[kT30][4].value == Approx(1.1));
    // The pairs are not independent.
    CHECK_FALSE(average.mean.octaves[kT30][4].standard_error);
    CHECK(*average.deviation.octaves[kT30][4].value == Approx(0.1 * std::sqrt(2)));
    // A single value has no deviation.
    CHECK(*average.mean.broadband[kT30].value == Approx(2));
    CHECK_FALSE(average.deviation.broadband[kT30].value);
    CHECK(*average.mean.sti.value == Approx(0.5));
    CHECK_FALSE(average.mean.octaves[kT30][3].value);
    CHECK(average.counts.octaves[kT30][4].value == 2.0);
    CHECK(average.counts.sti.value == 1.0);
    CHECK_FALSE(average.counts.octaves[kT30][3].value);
    CHECK(average_over_positions({}).positions == 0);
}

TEST_CASE("The Schroeder frequency of 2 s in 200 m3 is 200 Hz") {
    CHECK(schroeder_frequency_hz(2, 200) == Approx(200));
}
