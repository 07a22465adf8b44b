#include "engine/cache/segment_cache.h"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "engine/trace/detection_spheres.h"

namespace segment_cache_test {

using namespace aula;

namespace {

constexpr float kRadius_m = 0.5F;
constexpr int kRays = 10;
constexpr std::size_t kMax = 20;
constexpr std::size_t kMemory_bytes = 1 << 20;

/// A segment from the origin along x of a path that was 3 m long before.
DepositBatch one_segment(float length_m = 100) {
    DepositBatch batch;
    batch.segments.push_back({Vec3(0), Vec3(1, 0, 0), length_m, 3, 0});
    batch.segment_energies.push_back({Bands::filled(0.5F), Vec3(-1, 0, 0), 0});
    return batch;
}

SegmentCache window(std::size_t memory_bytes = kMemory_bytes) {
    return {4, 0.5F, Bands{}, kMax, memory_bytes};
}

/// Frames of one segment each, with the emitter moving by `step_m` from frame to frame.
void run(SegmentCache& segments, std::uint64_t first, std::uint64_t frames, float step_m = 0) {
    for (std::uint64_t f = first; f < first + frames; ++f) {
        segments.advance({f, Vec3(0, step_m * static_cast<float>(f), 0), 0});
        const DepositBatch batch = one_segment();
        segments.add({&batch, 1}, kRays);
    }
}

/// `scale` times what is detected of the segments of one ray.
EnergyResponse detected(const SegmentCache& segments, const Vec3& at, double scale) {
    static const RayScene open{Scene{}};
    EnergyResponse response = EnergyResponse::silent(TimeBins(0.2));
    SpecularSum sum(response);
    segments.add_to(open, {at, kRadius_m}, {}, false, segments.rays(), sum);
    sum.add_to(SpecularSound{}, response);
    for (Bands& energy : response.energy) {
        energy *= static_cast<float>(scale * static_cast<double>(sum.rays()));
    }
    for (DirectionMoments& directions : response.directions) {
        directions *= static_cast<float>(scale * static_cast<double>(sum.rays()));
    }
    return response;
}

}  // namespace

TEST_CASE(
    "a receiver detects a segment in proportion to its chord, at its delay, at any position") {
    SegmentCache segments = window();
    run(segments, 0, 1);
    constexpr float kVolume_m3 =
        4.0F / 3 * std::numbers::pi_v<float> * kRadius_m * kRadius_m * kRadius_m;
    for (const float x : {2.0F, 20.0F}) {
        const EnergyResponse response = detected(segments, Vec3(x, 0.3F, 0), 1.0 / kRays);
        const std::size_t bin = response.bins.index(double{x + 3} / 343.2);
        // The chord 0.3 m from the centre is 0.8 m long. Rounding of squares of 20 m: 1e-5 of it.
        const float energy = 0.5F * 0.8F / kVolume_m3 / kRays;
        CHECK(response.energy[bin][0] == Approx(energy).epsilon(1e-4));
        CHECK(response.directions[bin].intensity.x == Approx(-8 * energy).epsilon(1e-4));
        CHECK(response.total(0) == Approx(double{energy}).epsilon(1e-4));
    }
    // Segments of a frame are tested many at a time.
    SegmentCache many(4, 0.5F, Bands{}, 100, kMemory_bytes);
    std::vector<DepositBatch> batches(40);
    for (std::size_t i = 0; i < batches.size(); ++i) {
        batches[i] = one_segment();
        batches[i].segments[0].origin.y = static_cast<float>(i) + 5;
        batches[i].segment_energies[0].energy *= static_cast<float>(i);
    }
    many.add(batches, kRays);
    for (const std::size_t i : {0U, 15U, 16U, 37U}) {
        const auto k = static_cast<float>(i);
        const EnergyResponse response = detected(many, Vec3(2, k + 5.3F, 0), 1);
        const float energy = 0.5F * 0.8F * k / kVolume_m3;
        CHECK(response.total(0) == Approx(double{energy}).epsilon(1e-4));
    }
    // Not at the origin, where no segment begins.
    CHECK(detected(many, Vec3(0), 1).total(0) == 0);
    // Companion: beside it, and beyond the segment's end.
    CHECK(detected(segments, Vec3(2, 0.6F, 0), 1).total(0) == 0);
    CHECK(detected(segments, Vec3(101, 0, 0), 1).total(0) == 0);
}

TEST_CASE("the segments of all frames are detected, or of the present one only") {
    SegmentCache segments = window();
    run(segments, 0, 3);
    static const RayScene open{Scene{}};
    for (const bool only_present : {false, true}) {
        EnergyResponse response = EnergyResponse::silent(TimeBins(0.2));
        SpecularSum sum(response);
        segments.add_to(open, {Vec3(2, 0.3F, 0), kRadius_m}, {}, only_present, segments.rays(),
                        sum);
        CHECK(sum.rays() == (only_present ? 1 : 3) * kRays);
        sum.add_to(SpecularSound{}, response);
        // Each ray of each frame has the same mean.
        CHECK(response.total(0) * static_cast<double>(kRays) ==
              Approx(detected(segments, Vec3(2, 0.3F, 0), 1.0 / 3).total(0)).epsilon(1e-5));
    }
}

TEST_CASE("the sphere of a segment grows with the length of the path before it") {
    DepositBatch batch = one_segment();
    batch.segments[0].growth = 100;
    SegmentCache segments = window();
    segments.advance({0, Vec3(0), 0});
    segments.add({&batch, 1}, kRays);
    // After 3 m one of ten rays represents 4 / (10 R^2) (3 m)^2 = 14.4 cross-sections: a sphere of
    // 2^(7/4) radii. Its chord 0.3 m from the centre; rounding of squares of 20 m.
    const double radius_m = double{kRadius_m} * std::exp2(1.75);
    const double chord_m = 2 * std::sqrt(radius_m * radius_m - 0.3 * 0.3);
    const double volume_m3 = 4.0 / 3 * std::numbers::pi * std::pow(radius_m, 3);
    CHECK(detected(segments, Vec3(20, 0.3F, 0), 1).total(0) ==
          Approx(0.5 * chord_m / volume_m3).epsilon(1e-4));
    // After 100 m the energy of the segment limits it: 100 cross-sections, 2^(13/4) radii.
    batch.segments[0].before_m = 100;
    SegmentCache late = window();
    late.advance({0, Vec3(0), 0});
    late.add({&batch, 1}, kRays);
    CHECK_FALSE(detected(late, Vec3(20, 0.3F, 0), 1).total(0) ==
                Approx(0.5 * chord_m / volume_m3).epsilon(0.1));
}

TEST_CASE("air attenuates a segment up to the receiver") {
    Bands attenuation_per_m;
    attenuation_per_m[6] = 0.008F;
    attenuation_per_m[7] = 0.024F;
    SegmentCache segments(4, 0.5F, attenuation_per_m, kMax, kMemory_bytes);
    run(segments, 0, 1);
    for (const float x : {2.0F, 50.0F}) {
        const EnergyResponse response = detected(segments, Vec3(x, 0.3F, 0), 1.0 / kRays);
        // The energy of a segment includes earlier losses. Rounding of exponentials.
        for (const std::size_t b : {6U, 7U}) {
            CHECK(response.total(b) / response.total(0) ==
                  Approx(std::exp(-double{attenuation_per_m[b]} * double{x})).epsilon(1e-5));
        }
    }
}

TEST_CASE("segments of a static emitter are kept until newer ones need their memory") {
    SegmentCache segments = window();
    run(segments, 0, 15);
    CHECK(segments.rays() == 15 * kRays);
    CHECK(segments.is_current());
    CHECK_FALSE(segments.full());
    run(segments, 15, 15);
    CHECK(segments.rays() == kMax * kRays);
    CHECK(segments.full());
    // The window's four frames are kept if there are many segments, unless memory is short.
    SegmentCache full = {4, 0.5F, Bands{}, 1, kMemory_bytes};
    run(full, 0, 15);
    CHECK(full.rays() == 4 * kRays);
    SegmentCache two = window();
    run(two, 0, 2);
    SegmentCache small = window(two.memory_bytes());
    run(small, 0, 15);
    CHECK(small.rays() == 2 * kRays);
}

TEST_CASE("of a frame that exceeds the memory a random part represents all") {
    // The later a segment, the more energy it has: the first 850 would have two fifths too little.
    std::vector<DepositBatch> batches(4000, one_segment());
    for (std::size_t k = 0; k < batches.size(); ++k)
        batches[k].segment_energies[0].energy *= static_cast<float>(k + 2000) / 4000;
    SegmentCache all = window();
    all.add(batches, 4000);
    CHECK(all.rays() == 4000);
    SegmentCache some = window(100'000);
    some.add(batches, 4000);
    CHECK(some.memory_bytes() <= 100'000);
    CHECK(some.memory_bytes() > 95'000);
    CHECK(some.rays() < 1200);
    // Evenly from all batches: exact to about one of the 850 segments.
    const Vec3 receiver(2, 0.3F, 0);
    const auto per_ray = [&](const SegmentCache& segments) {
        return detected(segments, receiver, 1.0 / static_cast<double>(segments.rays())).total(0);
    };
    CHECK(per_ray(some) == Approx(per_ray(all)).epsilon(0.002));
}

TEST_CASE("after a movement of an emitter its old segments are not detected") {
    SegmentCache slow = window();
    run(slow, 0, 15, 0.01F);
    CHECK(slow.rays() == 4 * kRays);  // of the window
    CHECK_FALSE(slow.is_current());
    SegmentCache fast = window();
    run(fast, 0, 15, 0.3F);
    CHECK(fast.rays() == 2 * kRays);  // 0.6 m are too far
    SegmentCache stopped = window();
    run(stopped, 0, 15);
    stopped.advance({15, Vec3(0, 0.1F, 0), 0});
    // With these fifteen, three frames of a window of four remain.
    CHECK(stopped.rays() == 3 * kRays);
    stopped.advance({20, Vec3(0, 0.1F, 0), 0});
    CHECK(stopped.rays() == 0);
}

TEST_CASE("a segment that begins within the sphere is detected from its start only") {
    SegmentCache segments = window();
    run(segments, 0, 1);
    constexpr float kVolume_m3 =
        4.0F / 3 * std::numbers::pi_v<float> * kRadius_m * kRadius_m * kRadius_m;
    // Of the chord of 0.8 m, 0.4 m to either side of the sphere's centre.
    for (const auto& [x, chord_m] : {std::pair{0.2F, 0.6F}, {-0.2F, 0.2F}, {0.4F, 0.8F}}) {
        CAPTURE(x);
        CHECK(detected(segments, Vec3(x, 0.3F, 0), 1.0 / kRays).total(0) ==
              Approx(0.5 * double{chord_m} / double{kVolume_m3} / kRays).epsilon(1e-4));
    }
    CHECK(detected(segments, Vec3(-0.41F, 0.3F, 0), 1).total(0) == 0);
}

TEST_CASE("a segment of high energy has a larger sphere and the same mean detection") {
    SegmentCache segments = window();
    DepositBatch batch = one_segment();
    batch.segments[0].growth = 4;  // less than one ray of its wave front would allow: 14.4
    segments.add({&batch, 1}, kRays);
    // Sphere 4 of twice the radius; the line passes 0.8 m from its centre.
    const float radius_m = 2 * kRadius_m;
    const float volume_m3 = 4.0F / 3 * std::numbers::pi_v<float> * radius_m * radius_m * radius_m;
    CHECK(detected(segments, Vec3(20, 0.8F, 0), 1.0 / kRays).total(0) ==
          Approx(0.5 * 1.2 / double{volume_m3} / kRays).epsilon(1e-4));
    CHECK(detected(segments, Vec3(20, 1.01F, 0), 1).total(0) == 0);
}

TEST_CASE("segments that an image source may count keep the small sphere for any energy") {
    DepositBatch batch;
    for (int i = 0; i < 100; ++i) {
        batch.segments.push_back({Vec3(0), Vec3(1, 0, 0), 10, 3, 0});
        batch.segment_energies.push_back({Bands::filled(i < 2 ? 1.0F : 0.01F), Vec3(-1, 0, 0), 0});
    }
    batch.segment_energies[1].image = 77;
    size_spheres(std::span(&batch, 1));
    CHECK(batch.segments[0].growth > 4);
    CHECK(batch.segments[1].growth <= 1);
    CHECK(batch.segments[2].growth == 4);
}

TEST_CASE(
    "paths that an image source may count and paths that scatter have separate cache entries") {
    ArrivalBatch batch;
    for (const std::uint64_t sequence : {0U, 77U}) {
        batch.segments.push_back({Vec3(0), Vec3(1, 0, 0), 10, 3, 0});
        batch.segment_energies.push_back({Bands::filled(1), Vec3(-1, 0, 0), sequence});
        batch.segment_identifiers.push_back(PathIdentifier::start(0));  // of the same patches
    }
    const RayScene open{Scene{}};
    const Receiver receiver{Vec3(5, 0, 0), kRadius_m};
    collect_segment_arrivals(open, {&receiver, 1}, Bands{}, kRays, batch);
    REQUIRE(batch.arrivals.size() == 2);
    CHECK(!(batch.arrivals[0].path == batch.arrivals[1].path));
}

TEST_CASE("A cache that evicted valid frames is full until emitter or scene change") {
    SegmentCache segments = window();
    run(segments, 0, kMax);
    CHECK_FALSE(segments.full());
    // Each frame after the 20 segments that the cache holds evicts the oldest one.
    run(segments, kMax, 1);
    CHECK(segments.full());
    segments.advance({kMax + 1, Vec3(0), 0});
    CHECK(segments.full());
    segments.advance({kMax + 2, Vec3(0, 0.01F, 0), 0});
    CHECK_FALSE(segments.full());
}

}  // namespace segment_cache_test
