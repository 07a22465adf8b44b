#include "aula/engine/propagation.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <vector>

#include "engine/base/sampling.h"
#include "engine/cache/diffuse_path_cache.h"
#include "engine/frame_rays.h"
#include "engine/trace/arrival_tracer.h"
#include "tests/support/measure.h"
#include "tests/support/rooms.h"
#include "tests/support/statistics.h"
#include "tests/support/test_scenes.h"

namespace propagation_test {

using namespace aula;
using aula::test::with;

namespace {

Scene box_room(float absorption = 0.2F, float scattering = 1) {
    return test::grey_room(test::box(Vec3(5, 4, 3)), absorption, scattering, Vec3(1.2F, 1.1F, 1.5F),
                           Vec3(3.7F, 2.9F, 1.2F));
}

double total(const EnergyResponse& response) { return test::total(response); }

}  // namespace

TEST_CASE("with tau = 0 the cache has the energies of plain path tracing to the bit") {
    const Scene scene = box_room();
    const RayScene rays(scene);
    const PatchSubdivision subdivision(rays, 0.5F);
    TraceSettings settings;
    settings.rays = 2000;
    settings.max_length_m = 200;
    const SpecularPaths images(rays, 0, 0.5F, 1);
    const ArrivalTracer tracer(rays, subdivision, images, settings);
    for (const auto readout :
         {DiffusePathCache::Readout::published, DiffusePathCache::Readout::windowed}) {
        DiffusePathCache cache(readout, 1, 1'000'000'000);
        for (int frame = 0; frame < 3; ++frame) {
            ArrivalBatch all;
            for (int b = 0; b < tracer.batch_count(); ++b) {
                const Receiver receiver{scene.listener.pose.position};
                tracer.trace({0, scene.sources[0].position}, {&receiver, 1}, derive_seed(1, frame),
                             b, all);
            }
            REQUIRE(all.arrivals.size() > 100);
            cache.add_frame(all.arrivals, settings.rays);
            std::map<std::pair<std::uint64_t, std::uint64_t>, std::array<std::int64_t, kBandCount>>
                plain;
            for (const Arrival& a : all.arrivals) {
                auto& sums = plain[{a.path.low, a.path.high}];
                for (std::size_t b = 0; b < kBandCount; ++b) {
                    sums[b] += DiffusePathCache::to_fixed(a.energy[b]);
                }
            }
            CHECK(cache.size() == plain.size());
            for (const auto& [path, sums] : plain) {
                const auto* entry = cache.find({path.first, path.second});
                REQUIRE(entry);
                CHECK(entry->energy_sum == sums);
            }
        }
    }
}

TEST_CASE("with tau = 0 and lambda -> 0 the echogram is that of plain path tracing") {
    const Scene scene = box_room();
    Propagation plain(scene, with(scene, Estimator::pt, 0.5F));
    for (const Estimator estimator : {Estimator::dpc, Estimator::dpc_published}) {
        Simulation simulation = with(scene, estimator, 0.5F, 0);
        simulation.patch_size_m = 1e-4F;
        Propagation cached(scene, simulation);
        plain.restart(1);
        for (int frame = 0; frame < 3; ++frame) {
            plain.step(test::static_input(scene));
            cached.step(test::static_input(scene));
            const auto& a = plain.response(0);
            const auto& b = cached.response(0);
            REQUIRE(total(a) > 0);
            for (std::size_t k = 0; k < a.bins.count(); ++k) {
                // Fixed point to 2^-32 and sums of a few floats in another order.
                CHECK(b.energy[k][4] == Approx(a.energy[k][4]).epsilon(1e-5).margin(1e-9));
            }
        }
    }
}

TEST_CASE("late fluence in a lossless room is c P / V, for any shape") {
    struct Shape {
        Object object;
        Vec3 source;
        Vec3 listener;
    };
    const std::vector<Shape> shapes{
        {test::box(Vec3(5, 4, 3)), Vec3(1.2F, 1.1F, 1.5F), Vec3(3.7F, 2.9F, 1.2F)},
        {test::icosphere(2.5F, 3), Vec3(0.5F, 0.3F, 0), Vec3(-1, 0.5F, 0.4F)},
        {test::l_shaped_room(), Vec3(5, 1.5F, 1.5F), Vec3(1.5F, 5, 1.2F)},
    };
    for (std::size_t i = 0; i < shapes.size(); ++i) {
        const Shape& shape = shapes[i];
        const double volume = test::volume_m3(shape.object);
        for (const float scattering : {1.0F, 0.4F}) {
            const Scene scene =
                test::grey_room(shape.object, 0, scattering, shape.source, shape.listener);
            const double exact = double{scene.medium.speed_of_sound_m_s()} / volume * (0.35 - 0.15);
            for (const Estimator estimator : {Estimator::pt, Estimator::dpc, Estimator::patch}) {
                Propagation propagation(scene, with(scene, estimator, 0.35F, 0.1F));
                const auto samples = test::restarts(
                    propagation, scene, 16, 3,
                    [](const EnergyResponse& r) { return test::energy_between(r, 0.15, 0.35); });
                const test::Estimate e = test::estimate(samples);
                CAPTURE(i, scattering, estimator_name(estimator), e.mean, e.standard_error, exact);
                // The L-shaped room has diffused to 1e-3 by 150 ms.
                CHECK(std::abs(e.mean - exact) < test::kFamilyZ * e.standard_error + 2e-3 * exact);
                CHECK(std::abs(e.z(1.15 * exact)) > test::kRefutedZ);  // companion
            }
        }
    }
}

TEST_CASE("air attenuates all energy that arrives at t by exp(-m c t), in every estimator") {
    // Grey walls: all bands have the same paths and can be compared bin by bin, without noise.
    for (const float scattering : {0.0F, 0.5F, 1.0F}) {
        Scene scene = test::grey_room(test::box(Vec3(30, 20, 12)), 0.1F, scattering, Vec3(8, 5, 2),
                                      Vec3(22, 14, 3));
        scene.medium.air_absorption = true;
        scene.simulation.rays = 300;
        const Bands m = scene.medium.attenuation_per_m();
        const double c = double{scene.medium.speed_of_sound_m_s()};
        for (const Estimator estimator : test::kAllEstimators) {
            Propagation propagation(scene, with(scene, estimator, 0.5F, 0.1F));
            for (int f = 0; f < 3; ++f) propagation.step(test::static_input(scene));
            const EnergyResponse& r = propagation.response(0);
            // In the mean over the response, each bin in proportion to its energy.
            double energy = 0;
            double without_air = 0;
            double time_s = 0;
            for (std::size_t k = 0; k < r.bins.count(); ++k) {
                const double middle_s = (r.bins.begin_s(k) + r.bins.end_s(k)) / 2;
                const double undone = std::exp(double{m[7] - m[0]} * c * middle_s);
                energy += double{r.energy[k][7]} * undone;
                without_air += double{r.energy[k][0]};
                time_s += double{r.energy[k][0]} * middle_s;
            }
            REQUIRE(without_air > 0);
            const double error = energy / without_air;
            CAPTURE(scattering, estimator_name(estimator), error, time_s / without_air);
            // The time of an arrival is known to its bin, up to 8 ms or 2.7 m: uniform within
            // +- 3.3 % of energy. Plain path tracing has some five arrivals with a standard error
            // of 0.9 %; four of these, and the rounding of deposits.
            CHECK(error == Approx(1).epsilon(0.04));
            // Companion: the omission of 10 m of a path would be a fifth.
            CHECK(std::exp(double{m[7] - m[0]} * 10) > 1.2);
        }
    }
}

TEST_CASE("dpc-published overestimates the energy of a lossless room") {
    const Scene scene = box_room(0);
    Propagation propagation(scene, with(scene, Estimator::dpc_published, 0.3F, 0.5F));
    const auto samples = test::restarts(propagation, scene, 6, 15, [](const EnergyResponse& r) {
        return test::energy_between(r, 0.1, 0.3);
    });
    const test::Estimate e = test::estimate(samples);
    const double exact = 343.2 / 60 * 0.2;
    CAPTURE(e.mean, e.standard_error, exact);
    // Nearly all paths of higher order are hit once in 15 frames: mean over true of the k-th frame
    // of an empty cache is H_15 = 3.3; the result must be far above 1.
    CHECK(e.mean > 2 * exact);
    CHECK(e.mean < 3.4 * exact);
}

TEST_CASE("patch agrees with plain path tracing for any scattering and each band") {
    Scene scene = box_room();
    scene.materials[0].absorption = {{0.1F, 0.2F, 0.3F, 0.4F, 0.5F, 0.2F, 0.1F, 0.3F}};
    scene.materials[0].scattering = {{0.1F, 0.2F, 0.4F, 0.6F, 0.8F, 1.0F, 0.3F, 0.0F}};
    Propagation plain(scene, with(scene, Estimator::pt, 0.3F));
    Propagation patch(scene, with(scene, Estimator::patch, 0.3F, 0.1F));
    // [early, late][band] samples of one energy each.
    using Samples = std::array<std::array<std::vector<double>, kBandCount>, 2>;
    const auto collect = [&](Propagation& propagation, int count, int frames) {
        Samples samples;
        test::restarts(propagation, scene, count, frames, [&](const EnergyResponse& r) {
            for (std::size_t band = 0; band < kBandCount; ++band) {
                samples[0][band].push_back(test::energy_between(r, 0, 0.05, band));
                samples[1][band].push_back(test::energy_between(r, 0.05, 0.15, band));
            }
            return 0.0;
        });
        return samples;
    };
    const Samples of_plain = collect(plain, 300, 1);
    const Samples of_patch = collect(patch, 16, 3);
    for (std::size_t part = 0; part < 2; ++part) {
        for (std::size_t band = 0; band < kBandCount; ++band) {
            const test::Estimate a = test::estimate(of_plain[part][band]);
            const test::Estimate b = test::estimate(of_patch[part][band]);
            const double error = std::hypot(a.standard_error, b.standard_error);
            CAPTURE(part, band, a.mean, b.mean, error);
            // The detection sphere averages over 0.5 m: up to 1 % at the onset.
            CHECK(std::abs(a.mean - b.mean) < test::kFamilyZ * error + 0.01 * a.mean);
            CHECK(error < 0.08 * a.mean);  // so that a missing or doubled part would be detected
        }
    }
}

TEST_CASE("patch finds the exact energy of every order in a Lambert box") {
    const double exact[] = {2.5561, 3.4597, 3.8235, 4.0175};  // 1e-2 P/m2 for rho = 1
    const Scene scene = box_room(0);
    double sum = 0;
    for (int order = 1; order <= 4; ++order) {
        sum += exact[order - 1] * 1e-2;
        Simulation simulation = with(scene, Estimator::patch, 0.3F, 0.5F);
        simulation.order = order;
        simulation.patch_size_m = 0.25F;
        Propagation propagation(scene, simulation);
        const test::Estimate e = test::estimate(test::restarts(propagation, scene, 24, 15, total));
        CAPTURE(order, e.mean, e.standard_error, sum);
        // Patches of 0.25 m smear the first order by less than 0.2 %.
        CHECK(std::abs(e.mean - sum) < test::kFamilyZ * e.standard_error + 2e-3 * sum);
        CHECK(std::abs(e.z(1.03 * sum)) > test::kRefutedZ);  // companion
    }
}

TEST_CASE("the rays stated in advance are those that a frame traces") {
    const Scene scene = box_room(0.2F, 0.5F);
    for (const Estimator estimator : {Estimator::dpc, Estimator::patch}) {
        Propagation propagation(scene, with(scene, estimator, 0.3F));
        const FrameInput input{0, {scene.sources[0].position}, {scene.listener.pose.position}};
        std::vector<Ray> before;
        for (int frame = 0; frame < 3; ++frame) {
            const std::vector<Ray> rays = FrameRays::of_next(propagation, input);
            propagation.step(input);
            CHECK(rays.size() == propagation.statistics().segments);
            CHECK(rays.front().origin == scene.sources[0].position);
            // Each frame has other rays.
            if (!before.empty()) CHECK(rays.front().direction != before.front().direction);
            before = rays;
        }
    }
}

TEST_CASE("the number of segments that end in mirrors is limited for all sources together") {
    // A smooth room without image sources, whose rays leave segments at each reflection.
    const auto memory_mb = [](std::size_t sources) {
        Scene scene = box_room(0.05F, 0);
        scene.sources.resize(sources, scene.sources[0]);
        Simulation simulation = with(scene, Estimator::patch, 0.4F);
        simulation.response_time_s = 0;  // a window of one frame is kept in any case
        simulation.rays = 400;
        simulation.specular_order = 0;
        simulation.memory_mb = 4096;
        Propagation propagation(scene, simulation);
        const FrameInput input{
            0, std::vector(sources, scene.sources[0].position), {scene.listener.pose.position}};
        for (int frame = 0; frame < 40; ++frame) propagation.step(input);
        return 1e-6 * static_cast<double>(propagation.statistics().memory_bytes);
    };
    const double one = memory_mb(1);
    CHECK(one > 4);                 // 65,536 segments of at least 64 bytes
    CHECK(memory_mb(8) < 2 * one);  // each cache may exceed its share by a frame
}

TEST_CASE("of static pairs two are gathered in a frame, each after as many frames as any other") {
    constexpr std::size_t kSources = 6;
    Scene scene = box_room();
    scene.sources.resize(kSources, scene.sources[0]);
    Simulation simulation = with(scene, Estimator::patch, 0.2F);
    simulation.rays = 100;
    simulation.response_time_s = 0.1F;  // 3 frames
    Propagation propagation(scene, simulation);
    FrameInput input{0, {}, {scene.listener.pose.position}};
    for (std::size_t s = 0; s < kSources; ++s)
        input.sources.push_back(scene.sources[0].position +
                                Vec3(0.1F * static_cast<float>(s), 0, 0));
    for (int frame = 0; frame < 10; ++frame) propagation.step(input);
    std::vector<double> last(kSources);
    const auto changed = [&] {
        std::vector<std::size_t> pairs;
        for (std::size_t s = 0; s < kSources; ++s) {
            const double now = total(propagation.response(s));
            if (now != last[s]) pairs.push_back(s);
            last[s] = now;
        }
        return pairs;
    };
    changed();
    std::vector<std::size_t> all;
    for (std::size_t frame = 0; frame < kSources / 2; ++frame) {
        propagation.step(input);
        const auto pairs = changed();
        CHECK(pairs.size() == 2);
        all.insert(all.end(), pairs.begin(), pairs.end());
    }
    std::sort(all.begin(), all.end());
    CHECK(all == std::vector<std::size_t>{0, 1, 2, 3, 4, 5});
}

TEST_CASE("less memory makes patches larger, without bias") {
    Scene scene = box_room(0);
    Simulation small = with(scene, Estimator::patch, 0.35F, 0.1F);
    small.memory_mb = 2;
    Propagation propagation(scene, small);
    CHECK(propagation.patch_size_m() > 1.2F * small.patch_size_m);
    const auto samples = test::restarts(propagation, scene, 16, 3, [](const EnergyResponse& r) {
        return test::energy_between(r, 0.15, 0.35);
    });
    const test::Estimate e = test::estimate(samples);
    CHECK(std::abs(e.z(343.2 / 60 * 0.2)) < test::kFamilyZ);
    CHECK(propagation.statistics().memory_bytes < 2'000'000);
    Propagation plenty(scene, with(scene, Estimator::patch, 0.35F, 0.1F));
    plenty.step(test::static_input(scene));
    CHECK(plenty.statistics().memory_bytes > 3'000'000);  // companion
}

TEST_CASE("directions point to the origin of the sound") {
    // Only a floor: all reflections arrive from below.
    Scene scene = test::grey_room(test::square(20), 0.1F, 1, Vec3(0, 0, 1.5F), Vec3(2, 0, 1.5F));
    for (const Estimator estimator :
         {Estimator::pt, Estimator::dpc_published, Estimator::dpc, Estimator::patch}) {
        Propagation propagation(scene, with(scene, estimator, 0.1F));
        for (int f = 0; f < 30; ++f) propagation.step(test::static_input(scene));
        const EnergyResponse& r = propagation.response(0);
        Vec3 sum(0);
        float energy = 0;
        for (std::size_t k = 0; k < r.bins.count(); ++k) {
            sum += r.directions[k].intensity;
            energy += r.energy[k].sum();
        }
        CAPTURE(estimator_name(estimator));
        REQUIRE(energy > 0);
        CHECK(test::fault(r).empty());  // directions no longer than their energy
        CHECK(sum.z / energy < -0.5F);
        // The floor between the two radiates most: from the source's side, minus x.
        CHECK(sum.x / energy < -0.1F);
        // About 30 rays arrive in a frame of plain path tracing; the others use many frames.
        if (estimator != Estimator::pt) CHECK(std::abs(sum.y / energy) < 0.1F);
    }
}

TEST_CASE("responses have the place of the listener, and a hash of the geometry as the room") {
    const auto response = [](const Scene& scene) {
        Propagation propagation(scene, with(scene, Estimator::patch, 0.1F, 0));
        propagation.step(test::static_input(scene));
        return propagation.response(0);
    };
    const EnergyResponse first = response(box_room());
    CHECK(first.listener == box_room().listener.pose.position);
    // Neither materials nor the listener's place change the carriers of tails.
    CHECK(response(box_room(0.5F)).room == first.room);
    Scene moved = box_room();
    moved.listener.pose.position.x -= 1;
    CHECK(response(moved).room == first.room);
    CHECK(response(moved).listener != first.listener);
    // Companion: another length, by a centimetre.
    const Scene longer = test::grey_room(test::box(Vec3(5.01F, 4, 3)), 0.2F, 1,
                                         Vec3(1.2F, 1.1F, 1.5F), Vec3(3.7F, 2.9F, 1.2F));
    CHECK(response(longer).room != first.room);
}

TEST_CASE("the response is as long as a decay by 70 dB, at most 10 s") {
    const auto length = [](float absorption) {
        const Scene scene = box_room(absorption);
        return Propagation(scene, scene.simulation).response_length_s();
    };
    // Eyring for 60 m3 and 94 m2: 0.46 s at 0.2, and the late decay of this box is 1.0444 times as
    // long. Steps of 8 ms and bins of 8 ms; a level with a standard error of 1 dB of 70.
    const double t_s = 1.0444 * 24 * std::log(10.0) * 60 / (343.2 * 94 * 0.22314);
    CHECK(length(0.2F) == Approx(70.0 / 60 * t_s).margin(0.016 + 2 * t_s / 60));
    CHECK(length(0) == 10);
}

TEST_CASE("the response is as long with a listener outside the room or with both ends in corners") {
    const auto length = [](const Vec3& source, const Vec3& listener) {
        Scene scene = box_room(0.2F);
        scene.sources[0].position = source;
        scene.listener.pose.position = listener;
        return Propagation(scene, scene.simulation).response_length_s();
    };
    const double inside_s = length({1, 1, 1}, {4, 2, 1});
    CHECK(length({1, 1, 1}, {40, 2, 1}) == Approx(inside_s).margin(0.02));
    CHECK(length({-40, 2, 1}, {4, 2, 1}) == Approx(inside_s).margin(0.02));
    // The particles begin with short segments.
    CHECK(length({0, 0, 0}, {5, 4, 3}) == Approx(inside_s).margin(0.04));
}

TEST_CASE("the response of a room whose walls all move is as long as that of a static room") {
    const auto length = [](bool moves) {
        Scene scene = box_room(0.2F);
        if (moves) scene.objects[0].path = Trajectory{{{0, {}}, {1, {Vec3(1, 0, 0)}}}, false};
        return Propagation(scene, scene.simulation).response_length_s();
    };
    // The same paths, up to rounding, so the same number of bins.
    CHECK(length(true) == length(false));
}

TEST_CASE("a path of a million points costs time in proportion to them") {
    // Every pair of points would be 1e12: hours.
    Scene scene = box_room(0.9F);
    scene.objects.clear();
    scene.listener.path.emplace();
    for (int p = 0; p < 1'000'000; ++p) {
        const Vec3 position(static_cast<float>(p % 1000), 0, 0);
        scene.listener.path->points.push_back({static_cast<double>(p), {position}});
    }
    scene.sources[0].position = Vec3(0);
    const Propagation propagation(scene, scene.simulation);
    // In free field the response includes the direct sound over the longest distance.
    const double direct_s = 999 / double{scene.medium.speed_of_sound_m_s()};
    CHECK(propagation.response_length_s() == Approx(0.1 + direct_s).margin(0.05));
}

TEST_CASE("After a restart every estimator gives the response of a new one with that seed") {
    Scene scene = test::small_room();
    const FrameInput input{0, {scene.sources[0].position}, {scene.listener.pose.position}};
    for (const Estimator estimator :
         {Estimator::pt, Estimator::dpc_published, Estimator::dpc, Estimator::patch}) {
        CAPTURE(estimator_name(estimator));
        scene.simulation.estimator = estimator;
        Propagation used(scene, scene.simulation);
        for (int frame = 0; frame < 3; ++frame) used.step(input);
        used.restart(77);
        CHECK(used.response(0).total(4) == 0);
        used.step(input);
        Simulation other = scene.simulation;
        other.seed = 77;
        Propagation fresh(scene, other);
        fresh.step(input);
        // Exact: the same rays.
        CHECK(used.response(0).total(4) > 0);
        CHECK(used.response(0).energy == fresh.response(0).energy);
        CHECK(used.statistics().cache_entries == fresh.statistics().cache_entries);
    }
}

TEST_CASE("while both ends hold rays, their gathers together trace hardly more rays than one") {
    // Without reflections each emitted ray and each gather ray has one segment.
    const Scene scene = box_room(1);
    Simulation simulation = with(scene, Estimator::patch, 0.35F);
    simulation.rays = 597;  // 7 batches of gather rays, of which each end has a part
    Propagation propagation(scene, simulation);
    FrameInput input = test::static_input(scene);
    const auto step = [&] {
        propagation.step(input);
        return propagation.statistics().segments;
    };
    std::uint64_t at_rest = 0;
    for (int f = 0; f < 10; ++f) at_rest = step();
    // While the source moves the listener emits; when it stops, the source emits as well.
    int shared = 0;
    for (int f = 0; f < 8; ++f) {
        if (f < 4) input.sources[0].x += 0.03F;
        const std::uint64_t segments = step();
        CAPTURE(f);
        // Two numbers are rounded up to batches of 128.
        CHECK(segments <= at_rest + 2 * 128);
        if (segments > at_rest) ++shared;
    }
    CHECK(shared > 0);
}

TEST_CASE("each source keeps its responses while others come and go") {
    for (const Estimator estimator : test::kAllEstimators) {
        Scene scene = box_room();
        scene.sources.push_back(scene.sources[0]);
        scene.sources[1].position.x += 1;
        Propagation propagation(scene, with(scene, estimator, 0.2F), 2);
        FrameInput input = test::static_input(scene);
        input.listeners.emplace_back(1, 3, 2);
        propagation.step(input);
        const EnergyResponse near = propagation.response(1, 0);
        const EnergyResponse far = propagation.response(1, 1);
        propagation.add_source({.position = {2, 2, 2}});
        propagation.remove_source(0);
        CHECK(propagation.source_count() == 2);
        CHECK(test::same_bits(propagation.response(0, 0), near));
        CHECK(test::same_bits(propagation.response(0, 1), far));
        CHECK_FALSE(test::same_bits(near, far));  // companion
        for (const std::size_t listener : {0U, 1U}) {
            CHECK(total(propagation.response(1, listener)) == 0);
            CHECK(propagation.response(1, listener).paths.empty());
        }
    }
}

}  // namespace propagation_test
