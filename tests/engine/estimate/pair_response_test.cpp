#include "engine/estimate/pair_response.h"

#include <catch2/catch.hpp>

using aula::Bands;
using aula::DirectionMoments;
using aula::EnergyResponse;
using aula::PairResponse;
using aula::TimeBins;
using aula::Vec3;

namespace {

constexpr double kLength_m = 3.5;

/// Gathers one arrival of this energy from +x, with `rays` rays in the caches.
void gather(PairResponse& pair, float energy, std::uint64_t rays, bool changed) {
    pair.begin_frame(changed ? 0.1 : 0);
    pair.begin_gather();
    pair.gathered().add(kLength_m, Bands::filled(energy),
                        DirectionMoments::of(Vec3(1, 0, 0)) * (8 * energy));
    pair.end_gather(rays);
}

/// The mean energy per band; checks that energy and intensity have the same mean.
double mean(const PairResponse& pair) {
    const EnergyResponse& response = pair.response();
    const std::size_t bin = response.bins.index(kLength_m / double{response.speed_of_sound_m_s});
    CHECK(response.directions[bin].intensity.x == Approx(response.energy[bin].sum()));
    return double{response.energy[bin][0]};
}

PairResponse silent_pair() { return PairResponse(EnergyResponse::silent(TimeBins(0.05)), 16); }

}  // namespace

TEST_CASE("the response of a static pair is the mean of its frames, weighted by their rays") {
    PairResponse pair = silent_pair();
    gather(pair, 8, 1000, true);
    CHECK(mean(pair) == 8);
    gather(pair, 4, 3000, false);
    CHECK(mean(pair) == Approx(5));
    gather(pair, 1, 4000, false);
    CHECK(mean(pair) == Approx(3));
    CHECK(pair.holds(3));
    CHECK_FALSE(pair.holds(4));
    CHECK(pair.frames() == 3);
}

TEST_CASE("the mean of a pair restarts after a change") {
    PairResponse pair = silent_pair();
    gather(pair, 8, 1000, false);
    gather(pair, 2, 1000, true);
    CHECK(mean(pair) == 2);
    CHECK_FALSE(pair.holds(1));
    gather(pair, 6, 1000, false);
    CHECK(mean(pair) == Approx(4));
    CHECK(pair.holds(2));
    CHECK_FALSE(pair.holds(3));
    // A change invalidates the mean before the next gather.
    pair.begin_frame(0.1);
    CHECK_FALSE(pair.holds(1));
}

TEST_CASE("Detections on segments are smoothed while an end moves, but not those of an image") {
    // A segment along x with this energy, detected after 60 m; rays of one frame only.
    const auto detect = [](PairResponse& pair, std::uint64_t frame, float energy,
                           std::uint64_t image) {
        static const aula::RayScene open{aula::Scene{}};
        constexpr int kRays = 10;
        aula::DepositBatch batch;
        batch.segments.push_back({Vec3(0), Vec3(1, 0, 0), 100, 40, 0});
        batch.segment_energies.push_back({Bands::filled(energy), Vec3(-1, 0, 0), image});
        aula::SegmentCache of_source(1, 0.5F, Bands{}, 20, 1 << 20);
        const aula::SegmentCache of_listener(1, 0.5F, Bands{}, 20, 1 << 20);
        of_source.advance({frame, Vec3(0), 0});
        of_source.add({&batch, 1}, kRays);
        pair.begin_frame(0.01);
        pair.detect(open, of_source, {Vec3(20, 0, 0), 0.5F}, of_listener, {}, {});
        EnergyResponse response = EnergyResponse::silent(TimeBins(0.3));
        pair.add_detected_to({}, response);
        const std::size_t bin = response.bins.index(60 / 343.2);
        CHECK(response.directions[bin].intensity.x == Approx(-response.energy[bin].sum()));
        return double{response.energy[bin][0]};
    };
    for (const std::uint64_t image : {0U, 7U}) {
        CAPTURE(image);
        PairResponse pair(EnergyResponse::silent(TimeBins(0.3)), 16);
        // The energy of every second frame differs by the factor 3.
        const double low = detect(pair, 0, 1, image);
        CHECK(low > 0);
        double last = 0;
        double before = 0;
        for (std::uint64_t frame = 1; frame < 100; ++frame) {
            before = last;
            last = detect(pair, frame, frame % 2 == 0 ? 1 : 3, image);
        }
        if (image != 0) {
            CHECK(before == Approx(low));
            CHECK(last == Approx(3 * low));
        } else {
            CHECK(before == Approx(2 * low).epsilon(0.1));
            CHECK(last == Approx(2 * low).epsilon(0.1));
        }
    }
}
