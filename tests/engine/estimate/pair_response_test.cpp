#include "engine/estimate/pair_response.h"

#include <catch2/catch.hpp>

using aula::Bands;
using aula::EnergyResponse;
using aula::PairResponse;
using aula::TimeBins;
using aula::Vec3;

namespace {

constexpr double kLength_m = 3.5;

/// Gathers one arrival of this energy from +x, with `rays` rays in the caches.
void gather(PairResponse& pair, float energy, std::uint64_t rays, bool changed, bool is_current) {
    pair.begin_frame(changed ? 0.1 : 0);
    pair.begin_gather();
    pair.gathered().add(kLength_m, Bands::filled(energy), Vec3(8 * energy, 0, 0));
    pair.end_gather(rays, is_current);
}

/// The mean energy per band; checks that energy and intensity have the same mean.
double mean(const PairResponse& pair) {
    const EnergyResponse& response = pair.response();
    const std::size_t bin = response.bins.index(kLength_m / double{response.speed_of_sound_m_s});
    CHECK(response.intensity[bin].x == Approx(response.energy[bin].sum()));
    return double{response.energy[bin][0]};
}

PairResponse silent_pair() { return PairResponse(EnergyResponse::silent(TimeBins(0.05)), 16); }

}  // namespace

TEST_CASE("the response of a static pair is the mean of its frames, weighted by their rays") {
    PairResponse pair = silent_pair();
    gather(pair, 8, 1000, true, true);
    CHECK(mean(pair) == 8);
    gather(pair, 4, 3000, false, true);
    CHECK(mean(pair) == Approx(5));
    gather(pair, 1, 4000, false, true);
    CHECK(mean(pair) == Approx(3));
    CHECK(pair.holds(3));
    CHECK_FALSE(pair.holds(4));
}

TEST_CASE("the mean of a pair restarts after a change, and while the caches hold older frames") {
    PairResponse pair = silent_pair();
    gather(pair, 8, 1000, false, true);
    gather(pair, 2, 1000, true, false);
    CHECK(mean(pair) == 2);
    CHECK_FALSE(pair.holds(1));
    // The caches still hold frames from before the change: each frame alone.
    gather(pair, 4, 1000, false, false);
    CHECK(mean(pair) == 4);
    // The first frame without them does not join earlier ones.
    gather(pair, 6, 1000, false, true);
    CHECK(mean(pair) == 6);
    CHECK(pair.holds(1));
    gather(pair, 8, 1000, false, true);
    CHECK(mean(pair) == Approx(7));
    // A change invalidates the mean before the next gather.
    pair.begin_frame(0.1);
    CHECK_FALSE(pair.holds(1));
}
