#include "engine/trace/detection_spheres.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <span>
#include <utility>
#include <vector>

#include "engine/base/sampling.h"
#include "tests/engine/trace/traced_room.h"
#include "tests/support/rooms.h"
#include "tests/support/statistics.h"

namespace detection_spheres_test {

using namespace aula;
using test::TracedRoom;

namespace {

constexpr float kPi = std::numbers::pi_v<float>;

}  // namespace

TEST_CASE(
    "spheres that grow with a segment's energy preserve late specular levels and reduce their "
    "noise") {
    // A box with one pair of hard walls: few rays between them carry its late sound. Exact by
    // images of all orders.
    const Vec3 size(12, 9, 5);
    const Vec3 source = size * Vec3(0.22F, 0.39F, 0.31F);
    const Vec3 listener = size * Vec3(0.71F, 0.62F, 0.27F);
    Scene scene = test::grey_room(test::box(size), 0.4F, 0, source, listener);
    scene.materials.push_back(scene.materials[0]);
    scene.materials[1].absorption = Bands::filled(0.03F);
    Object& walls = scene.objects[0];
    for (std::size_t t = 0; t < walls.triangles.size(); ++t) {
        const auto& [a, b, c] = walls.triangles[t];
        const bool across = walls.vertices[a].x == walls.vertices[b].x &&
                            walls.vertices[a].x == walls.vertices[c].x;
        walls.triangle_materials[t] = across ? 1 : 0;
    }
    constexpr int kBins = 10;
    constexpr float kFirst_m = 34;
    constexpr float kBin_m = 17;
    const auto bin_of = [](double length_m) {
        return static_cast<int>(std::floor((length_m - double{kFirst_m}) / double{kBin_m}));
    };
    std::vector<double> exact(kBins);
    const auto along = [&](int axis, int n) {
        const double length = double{size[axis]};
        const double at = double{source[axis]};
        return (n % 2 == 0 ? n * length + at : (n + 1) * length - at) - double{listener[axis]};
    };
    for (int i = -20; i <= 20; ++i) {
        for (int j = -25; j <= 25; ++j) {
            for (int k = -43; k <= 43; ++k) {
                const double d = std::hypot(along(0, i), along(1, j), along(2, k));
                const int bin = bin_of(d);
                if (bin < 0 || bin >= kBins) continue;
                exact[static_cast<std::size_t>(bin)] +=
                    std::pow(double{1 - 0.03F}, std::abs(i)) *
                    std::pow(double{1 - 0.4F}, std::abs(j) + std::abs(k)) /
                    (4 * double{kPi} * d * d);
            }
        }
    }

    TracedRoom traced(scene);
    traced.settings.rays = 6000;
    traced.settings.max_length_m = kFirst_m + kBins * kBin_m;
    const SpecularPaths images(traced.rays, 0, 0.5F, 1);
    const ArrivalTracer tracer(traced.rays, traced.subdivision, images, traced.settings);
    const Receiver receiver = make_receiver(traced.rays, listener, 0.5F);
    constexpr std::size_t kFrames = 48;
    struct Run {
        std::vector<std::vector<double>> levels{kBins};  ///< [bin][frame] over the exact ones
        std::vector<double> hits = std::vector<double>(kBins);  ///< [bin] of all frames
        double arrivals = 0;
    };
    Run fixed;
    Run grown;
    for (std::size_t f = 0; f < kFrames; ++f) {
        std::vector<ArrivalBatch> batches(static_cast<std::size_t>(tracer.batch_count()));
        for (std::size_t b = 0; b < batches.size(); ++b) {
            tracer.trace({0, source}, {}, derive_seed(test::test_seed(), f), static_cast<int>(b),
                         batches[b]);
        }
        const auto detect = [&](Run& run) {
            for (auto& bin : run.levels) bin.push_back(0);
            for (ArrivalBatch& batch : batches) {
                batch.arrivals.clear();
                collect_segment_arrivals(traced.rays, {&receiver, 1}, Bands{}, traced.settings.rays,
                                         batch);
                run.arrivals += static_cast<double>(batch.arrivals.size());
                for (const Arrival& a : batch.arrivals) {
                    const int bin = bin_of(double{a.length_m});
                    if (bin < 0 || bin >= kBins) continue;
                    run.hits[static_cast<std::size_t>(bin)] += 1;
                    run.levels[static_cast<std::size_t>(bin)].back() +=
                        double{a.energy[0]} / traced.settings.rays /
                        exact[static_cast<std::size_t>(bin)];
                }
            }
        };
        detect(fixed);
        size_spheres(std::span(batches));
        detect(grown);
    }
    double fixed_deviation = 0;
    double grown_deviation = 0;
    double of_equal_hits = 0;
    for (std::size_t k = 0; k < kBins; ++k) {
        const test::Estimate of_fixed = test::estimate(fixed.levels[k]);
        const test::Estimate of_grown = test::estimate(grown.levels[k]);
        const double max = *std::max_element(grown.levels[k].begin(), grown.levels[k].end());
        CAPTURE(k, exact[k], of_fixed.mean, of_fixed.standard_error, of_grown.mean,
                of_grown.standard_error, max);
        // Spheres of up to some metres may move an arrival to a neighbouring bin: 2 %.
        CHECK(std::abs(of_grown.mean - 1) < test::kFamilyZ * of_grown.standard_error + 0.02);
        CHECK(of_grown.standard_error < 0.08);  // so that the check is significant
        fixed_deviation += of_fixed.standard_error * std::sqrt(double{kFrames}) / kBins;
        grown_deviation += of_grown.standard_error * std::sqrt(double{kFrames}) / kBins;
        of_equal_hits += 1 / std::sqrt(grown.hits[k] / kFrames) / kBins;
    }
    // The relative standard deviation of a bin and frame. A hit has up to 16 times the mean energy
    // in spheres of equal or larger cross-section: at most four times that of equal chords,
    // sqrt(9/8) / sqrt(hits).
    CAPTURE(fixed_deviation, grown_deviation, of_equal_hits, fixed.arrivals, grown.arrivals);
    CHECK(grown_deviation < 4 * std::sqrt(9.0 / 8) * of_equal_hits);
    CHECK(fixed_deviation > 2 * grown_deviation);  // companion
    // Four times as many hits, and at most one more for four of mean energy in each band.
    CHECK(grown.arrivals < 4.4 * fixed.arrivals);
}

TEST_CASE("large spheres represent the part of a room that is visible from their centre") {
    // A lossless L-shaped room: fluence is the same everywhere, so that every sphere must find it
    // with any occlusion by walls.
    const Scene scene =
        test::grey_room(test::l_shaped_room(), 0, 0, Vec3(1, 5, 1), Vec3(4.5F, 1.2F, 1.6F));
    const RayScene rays(scene);
    const Receiver receiver = make_receiver(rays, Vec3(4.5F, 1.2F, 1.6F), 0.5F);
    const PatchSubdivision subdivision(rays, 1);
    const SpecularPaths images(rays, 0, 0.5F, 1);
    TracedRoom traced(scene);
    traced.settings.rays = 4000;
    traced.settings.max_length_m = 300;
    const ArrivalTracer tracer(rays, subdivision, images, traced.settings);
    std::vector<std::vector<double>> fluence(17);
    for (int f = 0; f < 8; ++f) {
        for (auto& of_sphere : fluence) of_sphere.push_back(0);
        for (int b = 0; b < tracer.batch_count(); ++b) {
            ArrivalBatch batch;
            tracer.trace({0, Vec3(1, 5, 1)}, {}, derive_seed(test::test_seed(), f), b, batch);
            for (const PathSegment& segment : batch.segments) {
                for (std::size_t k = 0; k < fluence.size(); k += 4) {
                    const auto chord = receiver.chord(rays, segment.origin, segment.direction,
                                                      segment.length_m, k);
                    if (!chord || segment.before_m + chord->at_m < 100) continue;
                    fluence[k].back() += double{chord->share_1_m2} / 4000;
                }
            }
        }
    }
    // c P / V per second, 81 m3, from 100 to 300 m.
    const double exact = 200.0 / 81;
    for (std::size_t k = 0; k < fluence.size(); k += 4) {
        const test::Estimate e = test::estimate(fluence[k]);
        CAPTURE(k, e.mean, e.standard_error, exact);
        // 2 % for 512 probes of the volume.
        CHECK(std::abs(e.mean - exact) < test::kFamilyZ * e.standard_error + 0.02 * exact);
    }
    // Companion: the volume of the whole ball instead of the visible part is far off.
    CHECK(receiver.seen_share[16] < 0.3F);
}

TEST_CASE("a growth selects the largest sphere whose cross-section does not exceed it") {
    for (std::size_t k = 0; k < Receiver::kSpheres; ++k) {
        CAPTURE(k);
        const float area = Receiver::radius_factor(k) * Receiver::radius_factor(k);
        CHECK(Receiver::sphere_of(1.001F * area) == k);
        if (k > 0) CHECK(Receiver::sphere_of(0.999F * area) == k - 1);
    }
    CHECK(Receiver::sphere_of(1e9F) == Receiver::kSpheres - 1);
}

TEST_CASE("bands with a mean below -100 dB do not enlarge detection spheres") {
    // In the quiet band one of 100 segments has half of the energy, which is 50 times the mean.
    const auto growth = [](float quiet_mean) {
        ArrivalBatch batch;
        for (int i = 0; i < 100; ++i) {
            batch.segments.push_back({.length_m = 100});
            Bands energy;
            energy[0] = 1;
            energy[1] = quiet_mean * (i == 0 ? 50.0F : 50.0F / 99);
            batch.segment_energies.push_back({energy});
        }
        size_spheres(std::span(&batch, 1));
        return double{batch.segments[0].growth};
    };
    // A quarter of the ratio to the mean, at least 4. Rounding of 100 sums.
    CHECK(growth(2e-10F) == Approx(50.0 / 4).epsilon(1e-5));
    CHECK(growth(0.5e-10F) == 4);
}

TEST_CASE("a segment's energy is compared with the mean at its own length of path") {
    // The mean length of a segment, 0.1 m, separates the segments that begin at 0 and at 0.15 m.
    ArrivalBatch batch;
    for (const auto& [before_m, energy] : {std::pair(0.0F, 1.0F), std::pair(0.15F, 100.0F)}) {
        batch.segments.push_back({.length_m = 0.1F, .before_m = before_m});
        batch.segment_energies.push_back({Bands::filled(energy)});
    }
    size_spheres(std::span(&batch, 1));
    for (const PathSegment& segment : batch.segments)
        CHECK(segment.growth == 4);  // alone, it has the mean energy
}

TEST_CASE("the spheres of segments that image sources may count do not grow") {
    ArrivalBatch batch;
    for (const std::uint64_t image : {0U, 7U}) {
        batch.segments.push_back({.length_m = 1});
        batch.segment_energies.push_back({Bands::filled(1), Vec3(0), image});
    }
    size_spheres(std::span(&batch, 1));
    CHECK(batch.segments[0].growth == 4);
    CHECK(batch.segments[1].growth == 0);
}

TEST_CASE("arrivals by two images have separate paths, although they meet the same patches") {
    const RayScene rays(test::grey_room(test::box(Vec3(5, 4, 3)), 0.1F, 0, Vec3(1), Vec3(3, 2, 1)));
    const Receiver receiver = make_receiver(rays, Vec3(3, 2, 1), 0.3F);
    ArrivalBatch batch;
    for (const std::uint64_t image : {5U, 7U}) {
        batch.segments.push_back(
            {.origin = Vec3(1, 2, 1), .direction = Vec3(1, 0, 0), .length_m = 4});
        batch.segment_energies.push_back({Bands::filled(1), Vec3(1, 0, 0), image});
        batch.segment_identifiers.push_back(PathIdentifier::start(0));
    }
    collect_segment_arrivals(rays, {&receiver, 1}, Bands{}, 100, batch);
    REQUIRE(batch.arrivals.size() == 2);
    CHECK(batch.arrivals[0].image == 5);
    CHECK_FALSE(batch.arrivals[0].path == batch.arrivals[1].path);
}

TEST_CASE("a receiver detects nothing behind a wall, even where its sphere hardly passes it") {
    // The spheres of these distances pass the wall by less than the probes of the visible share
    // find, or touch it. The segments end on the wall.
    const RayScene rays(test::grey_room(test::box(Vec3(5, 4, 3)), 0.1F, 1, Vec3(1), Vec3(2)));
    RandomStream random(test::test_seed());
    int detected = 0;
    int seen = 0;
    for (const float away_m : {1.0F, 0.9999F, 0.999F, 0.998F}) {
        const Receiver outside = make_receiver(rays, Vec3(5 + away_m, 2, 1.5F), 0.5F);
        const Receiver inside = make_receiver(rays, Vec3(5 - away_m, 2, 1.5F), 0.5F);
        for (int i = 0; i < 20000; ++i) {
            // The last segments are nearly parallel to the wall.
            const Vec3 end = Vec3(5, 2 + 0.05F * random.uniform(), 1.5F + 0.05F * random.uniform());
            const float slope = std::pow(10.0F, -4 * random.uniform());
            const Vec3 begin = end - Vec3(slope, random.uniform() - 0.5F, 1);
            const float length_m = glm::distance(begin, end);
            constexpr std::size_t kSphere = 4;  // of 1 m
            const Vec3 direction = (end - begin) / length_m;
            detected += outside.chord(rays, begin, direction, length_m, kSphere) ? 1 : 0;
            seen += inside.chord(rays, begin, direction, length_m, kSphere) ? 1 : 0;
        }
    }
    CHECK(detected == 0);
    CHECK(seen > 60000);  // companion: inside they are detected
}

}  // namespace detection_spheres_test
