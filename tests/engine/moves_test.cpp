// Responses while sources, listeners and geometry move.

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>

#include "aula/engine/propagation.h"
#include "aula/engine/scene_file.h"
#include "engine/base/sampling.h"
#include "tests/support/measure.h"
#include "tests/support/rooms.h"
#include "tests/support/statistics.h"
#include "tests/support/test_scenes.h"

namespace moves_test {

using namespace aula;
using aula::test::with;

namespace {

constexpr double kFrameRate_hz = 30;

Scene box_room(float scattering = 1) {
    return test::grey_room(test::box(Vec3(5, 4, 3)), 0.2F, scattering, Vec3(1.2F, 1.1F, 1.5F),
                           Vec3(3.7F, 2.9F, 1.2F));
}

Scene room(float scattering = 1) {
    Scene scene = box_room(scattering);
    scene.simulation.ir_length_s = 0.2F;
    scene.simulation.rays = 100;
    scene.simulation.response_time_s = 0.2F;  // six frames
    return scene;
}

double total(const EnergyResponse& response) { return test::total(response); }

/// Steps through `frames` frames of the source's positions with a static or walking listener.
EnergyResponse after(const Scene& scene, const std::vector<Vec3>& source, bool listener_walks) {
    Propagation propagation(scene, scene.simulation);
    for (std::size_t f = 0; f < source.size(); ++f) {
        FrameInput input = test::static_input(scene);
        input.sources[0] = source[f];
        if (listener_walks) input.listeners[0].x -= 0.02F * static_cast<float>(f);
        propagation.step(input);
    }
    return propagation.response(0);
}

/// A source that rests at one of two positions, then walks from a common position.
std::vector<Vec3> walk(const Vec3& before, int frames) {
    std::vector<Vec3> positions(20, before);
    for (int f = 0; f < frames; ++f) {
        positions.emplace_back(2 + 0.01F * static_cast<float>(f), 2, 1.2F);
    }
    return positions;
}

}  // namespace

TEST_CASE("from tau after a change on, nothing from before it remains in the caches") {
    for (const float scattering : {1.0F, 0.5F}) {
        const Scene scene = room(scattering);
        const int window = scene.simulation.window_frames();
        REQUIRE(window == 6);
        for (const bool listener_walks : {false, true}) {
            CAPTURE(scattering, listener_walks);
            const auto run = [&](const Vec3& before, int frames) {
                return after(scene, walk(before, frames), listener_walks);
            };
            // Two histories that differ in the source's position by less than a jump.
            const Vec3 here(1.9F, 2.1F, 1.2F);
            const Vec3 there(2, 1.9F, 1.1F);
            const EnergyResponse a = run(here, window);
            const EnergyResponse b = run(there, window);
            // To the bit in the early bins; later ones are smoothed.
            const auto early = static_cast<std::ptrdiff_t>(a.bins.index(0.032));
            CHECK(std::equal(a.energy.begin(), a.energy.begin() + early, b.energy.begin()));
            CHECK(std::equal(a.directions.begin(), a.directions.begin() + early,
                             b.directions.begin()));
            CHECK(a.total(0) > 0);
            const double difference = std::abs(a.total(0) / b.total(0) - 1);
            // A third, (5 / 6)^6, of a difference of less than a tenth.
            CHECK(difference < 0.03);
            // The tracking signals fade by a twentieth in each frame, the errors of the level
            // filters by a fortieth, to 0.05 in 20 windows.
            CHECK(std::abs(run(here, 20 * window).total(0) / run(there, 20 * window).total(0) - 1) <
                  0.1 * std::max(difference, 0.01));
            // Companion: right after the change the history has an effect.
            CHECK(run(here, 1).energy != run(there, 1).energy);
        }
    }
}

TEST_CASE("when a source stops, nothing of its walk remains after tau and its mean") {
    const Scene scene = room();
    const auto run = [&](float y, int rest) {
        std::vector<Vec3> positions;
        for (int f = 0; f < 12; ++f)
            positions.emplace_back(1.5F + 0.04F * static_cast<float>(f), y, 1);
        for (int f = 0; f < rest; ++f) positions.emplace_back(2, 2, 1);
        return after(scene, positions, false);
    };
    const int window = scene.simulation.window_frames();
    CHECK(run(2, 2 * window).energy == run(1.9F, 2 * window).energy);
    CHECK(run(2, 2).energy != run(1.9F, 2).energy);  // companion
}

TEST_CASE("the response of a static source does not depend on earlier positions of the listener") {
    // Mirrors and Lambert surfaces; rays find specular paths of all orders.
    const Scene scene = room(0.3F);
    const Vec3 here = scene.listener.pose.position;
    const auto at_last = [&](const Vec3& step, std::uint64_t seed) {
        Simulation simulation = scene.simulation;
        simulation.seed = seed;
        Propagation propagation(scene, simulation);
        constexpr int kFrames = 20;
        for (int f = 0; f <= kFrames + simulation.window_frames(); ++f) {
            FrameInput input = test::static_input(scene);
            input.listeners[0] = here + static_cast<float>(std::max(0, kFrames - f)) * step;
            propagation.step(input);
        }
        return propagation.response(0);
    };
    const EnergyResponse moved_slowly = at_last(Vec3(0.002F, 0, 0), 1);
    const EnergyResponse walked = at_last(Vec3(-0.1F, -0.05F, 0), 1);
    // Exact: the rays of all frames are gathered at the last position for any history.
    CHECK(moved_slowly.energy == walked.energy);
    CHECK(moved_slowly.directions == walked.directions);
    // Companion: other rays give another response.
    CHECK(moved_slowly.energy != at_last(Vec3(0.002F, 0, 0), 2).energy);
}

TEST_CASE("after a jump of the listener the response is that of the new position immediately") {
    const Scene scene = box_room();
    Propagation propagation(scene, with(scene, Estimator::patch, 0.3F));
    FrameInput input = test::static_input(scene);
    for (int f = 0; f < 30; ++f) propagation.step(input);
    input.listeners[0] = Vec3(1.5F, 1.3F, 1.4F);  // next to the source
    propagation.step(input);
    const double after = total(propagation.response(0));

    Scene there = scene;
    there.listener.pose.position = input.listeners[0];
    Propagation reference(there, with(there, Estimator::patch, 0.3F));
    const test::Estimate e = test::estimate(test::restarts(reference, there, 12, 15, total));
    // One frame more or less of the same statistics: 5 standard deviations of one restart.
    CHECK(std::abs(after - e.mean) < 5 * e.standard_error * std::sqrt(12.0));
    CHECK(e.standard_error * std::sqrt(12.0) < 0.02 * e.mean);
}

TEST_CASE("no energy older than tau remains of a source that has moved away") {
    // Two separate rooms; the source jumps from the listener's room to the other.
    Scene scene = box_room();
    scene.objects.push_back(test::box(Vec3(5, 4, 3), 0, Vec3(10, 0, 0)));
    scene.sources[0].path =
        Trajectory{{{0, {scene.sources[0].position}}, {1, {Vec3(12, 2, 1)}}}, false};
    constexpr int kWindow = 6;
    for (const Estimator estimator :
         {Estimator::pt, Estimator::dpc_published, Estimator::dpc, Estimator::patch}) {
        Propagation propagation(scene, with(scene, estimator, 0.3F, kWindow / 30.0F));
        FrameInput input = test::static_input(scene);
        for (int f = 0; f < 20; ++f) propagation.step(input);
        CHECK(total(propagation.response(0)) > 0);
        input.sources[0] = Vec3(12, 2, 1);
        for (int f = 0; f < kWindow; ++f) propagation.step(input);
        CAPTURE(estimator_name(estimator));
        CHECK(total(propagation.response(0)) == 0);
    }
}

TEST_CASE("a door that closes silences the room behind it within tau") {
    Scene scene = box_room();
    scene.objects.clear();
    // One long room, and a wall that slides into its middle.
    scene.objects.push_back(test::box(Vec3(10, 4, 3)));
    Object wall = test::box(Vec3(0.2F, 4.2F, 3.2F), 0, Vec3(0, -0.1F, -0.1F));
    wall.path = Trajectory{{{0, {Vec3(5, 5, 0)}}, {0.2, {Vec3(5, 0, 0)}}}, false};
    scene.objects.push_back(wall);
    scene.listener.pose.position = Vec3(8, 2, 1.2F);
    constexpr int kWindow = 5;
    Propagation propagation(scene, with(scene, Estimator::patch, 0.3F, kWindow / 30.0F));
    double open = 0;
    for (int f = 0; f < 7 + kWindow; ++f) {
        propagation.step(test::static_input(scene, f / 30.0));
        if (f == 0) open = total(propagation.response(0));
    }
    CHECK(open > 0);
    CHECK(total(propagation.response(0)) < 1e-4 * open);
}

TEST_CASE("0.3 s after a door has shut the level behind it is right within 1 dB") {
    const Scene scene = load_scene(AULA_SOURCE_DIR "/scenes/door.json").scene;
    Simulation simulation = scene.simulation;
    simulation.threads = 1;
    simulation.ir_length_s = 0.5F;
    constexpr double kShut_s = 3.5;
    FrameInput input = test::static_input(scene);
    input.listeners[0] = Vec3(7.2F, 1.2F, 1.2F);
    const auto energy = [](const EnergyResponse& response) {
        double sum = 0;
        for (std::size_t band = 0; band < kBandCount; ++band) sum += response.total(band);
        return sum;
    };
    // Converged: the door has been shut from the start.
    Propagation shut(scene, simulation);
    input.time_s = kShut_s;
    for (int f = 0; f < 150; ++f) shut.step(input);
    const double converged = energy(shut.response(0));
    // Some sixteen gather rays find the fanlight: the standard deviation of a level over seeds is
    // 0.22 dB, and 1 dB is four and a half times that.
    constexpr int kSeeds = 6;
    constexpr int kFirst = -24;
    constexpr int kLast = 9;  // 0.3 s
    std::vector<double> mean(kLast - kFirst + 1, 0.0);
    double farthest_db = 0;
    for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
        simulation.seed = seed;
        Propagation propagation(scene, simulation);
        for (int f = kFirst; f <= kLast; ++f) {
            input.time_s = kShut_s + f / kFrameRate_hz;
            propagation.step(input);
            mean[static_cast<std::size_t>(f - kFirst)] +=
                energy(propagation.response(0)) / kSeeds / converged;
        }
        const double off_db = 10 * std::log10(energy(propagation.response(0)) / converged);
        farthest_db = std::max(farthest_db, std::abs(off_db));
    }
    const auto error_db = [&](int f) {
        return 10 * std::log10(mean[static_cast<std::size_t>(f - kFirst)]);
    };
    for (int f = -15; f <= kLast; f += 3) {
        std::printf("door: %+5.2f s after it is shut %+6.2f dB\n", f / kFrameRate_hz, error_db(f));
    }
    std::printf("door: farthest of %d seeds %.2f dB\n", kSeeds, farthest_db);
    CHECK(farthest_db < 1);
    CHECK(error_db(kFirst) > 3);  // companion: the level with the open door is not accepted
}

TEST_CASE("late fluence in a lossless room is c P / V after any movement of an object") {
    // A block in the air, so that no faces touch; half of the incident energy is mirrored.
    Scene scene = test::grey_room(test::box(Vec3(5, 4, 3)), 0, 0.5F, Vec3(0.6F, 3.5F, 2.6F),
                                  Vec3(4.4F, 0.4F, 0.4F));
    Object block = test::box(Vec3(1.5F, 1.5F, 1.5F));
    block.path = Trajectory{{{0, {Vec3(0.4F, 0.4F, 0.7F)}}, {1, {Vec3(2.9F, 2.1F, 0.9F)}}}, false};
    scene.objects.push_back(block);
    const double volume_m3 = 60 - 1.5 * 1.5 * 1.5;
    const double exact = double{scene.medium.speed_of_sound_m_s()} / volume_m3 * (0.35 - 0.15);
    // From the initial position of the block, during its movement, and after it.
    for (const int last : {0, 15, 34}) {
        std::vector<double> samples;
        for (std::uint64_t seed = 1; seed <= 12; ++seed) {
            Simulation simulation = test::with(scene, Estimator::patch, 0.35F, 0.1F);
            simulation.seed = seed;
            simulation.rays = 500;
            Propagation propagation(scene, simulation);
            for (int f = std::max(0, last - 3); f <= last; ++f) {
                // First with a jump, then from frame to frame.
                propagation.step(test::static_input(scene, f / kFrameRate_hz));
            }
            samples.push_back(test::energy_between(propagation.response(0), 0.15, 0.35));
        }
        const test::Estimate e = test::estimate(samples);
        CAPTURE(last, e.mean, e.standard_error, exact);
        // Statistical, and the areas of patches that the block cuts, sampled at 64 points.
        CHECK(std::abs(e.mean - exact) < test::kFamilyZ * e.standard_error + 5e-3 * exact);
        // Companion: five per cent less is detected.
        CHECK(std::abs(e.z(0.95 * exact)) > test::kRefutedZ);
    }
}

TEST_CASE("while everything moves, memory is constant and below its limit") {
    Scene scene = room(0.6F);
    Object block = test::box(Vec3(0.5F, 0.5F, 0.5F));
    block.path = Trajectory{{{0, {Vec3(1, 1, 0.5F)}},
                             {3, {Vec3(4, 1, 0.5F)}},
                             {6, {Vec3(4, 3, 1.5F)}},
                             {9, {Vec3(1, 1, 0.5F)}}},
                            true};
    scene.objects.push_back(block);
    scene.sources.push_back(scene.sources[0]);
    scene.simulation.memory_mb = 2;
    scene.simulation.patch_size_m = 0.5F;
    Propagation propagation(scene, scene.simulation);
    std::array<std::size_t, 2> max{};
    constexpr int kFrames = 1600;
    for (int f = 0; f < kFrames; ++f) {
        FrameInput input = test::static_input(scene, f / kFrameRate_hz);
        // Walks, rests and jumps at different times.
        const auto phase = [&](int period) {
            return f % (2 * period) < period ? 0.04F * static_cast<float>(f % period) : 0.0F;
        };
        input.sources[0].x += phase(50);
        input.sources[1].y += phase(33);
        input.listeners[0].x -= phase(47);
        propagation.step(input);
        auto& part = max[f < kFrames / 2 ? 0 : 1];
        part = std::max(part, propagation.statistics().memory_bytes);
    }
    CHECK(max[0] < 2'000'000);
    // The second half may reach some new cells; keeping a row in every frame would be far more.
    CHECK(static_cast<double>(max[1]) < 1.02 * static_cast<double>(max[0]));
    // Companion: without the limit more is kept.
    scene.simulation.memory_mb = 100;
    Propagation free(scene, scene.simulation);
    for (int f = 0; f < 40; ++f) {
        FrameInput input = test::static_input(scene, f / kFrameRate_hz);
        input.sources[0].x += 0.01F * static_cast<float>(f);
        free.step(input);
    }
    CHECK(free.statistics().memory_bytes > max[0]);
}

TEST_CASE("after a rest a source that jumps is heard by rays of the listener") {
    Scene scene = box_room();
    scene.simulation.ir_length_s = 0.35F;
    scene.simulation.rays = 200;
    const auto deviation = [&](int rest, bool listener_jumps_before) {
        std::vector<double> energies;
        constexpr int kSeeds = 24;
        for (int seed = 1; seed <= kSeeds; ++seed) {
            scene.simulation.seed = static_cast<std::uint64_t>(seed);
            Propagation propagation(scene, scene.simulation);
            FrameInput input = test::static_input(scene);
            for (int f = 0; f < rest; ++f) propagation.step(input);
            if (listener_jumps_before) input.listeners[0] += Vec3(-1, -1, 0);
            if (listener_jumps_before) propagation.step(input);
            input.sources[0] += Vec3(1.5F, 1, 0);
            propagation.step(input);
            energies.push_back(test::energy_between(propagation.response(0), 0.1, 0.3));
        }
        const test::Estimate e = test::estimate(energies);
        return e.standard_error * std::sqrt(static_cast<double>(kSeeds)) / e.mean;
    };
    const double rested = deviation(120, false);
    // Companion: nothing is left of the reserve when the listener has moved.
    const double moved = deviation(120, true);
    std::printf("a source that jumps after a rest: deviation %.4f, of another listener %.4f\n",
                rested, moved);
    // Rays of eight frames in place of one or two; the gather has noise as well.
    CHECK(rested < 0.7 * moved);
}

TEST_CASE("The end that emits after a rest finds its memory reserved") {
    // Rays hit more patches of the church than the search for reached ones finds.
    Scene scene = load_scene(AULA_SOURCE_DIR "/scenes/church.json").scene;
    scene.simulation.rays = 200;
    Propagation propagation(scene, scene.simulation);
    constexpr int kRest = 60;
    std::size_t reserved = 0;
    for (int f = 0; f < kRest + 3; ++f) {
        FrameInput input = test::static_input(scene, 0);
        // A moved source lets the listener emit.
        input.sources[0].x += 0.02F * static_cast<float>(std::max(0, f + 1 - kRest));
        propagation.step(input);
        if (f == kRest - 1) reserved = propagation.statistics().memory_bytes;
    }
    CHECK(propagation.statistics().memory_bytes < reserved + reserved / 100);
}

TEST_CASE("The memory of both ends is mapped at load") {
    Scene scene = load_scene(AULA_SOURCE_DIR "/scenes/church.json").scene;
    scene.simulation.rays = 200;
    Propagation propagation(scene, scene.simulation);
    FrameInput input = test::static_input(scene, 0);
    std::vector<std::size_t> memory_bytes;
    for (int f = 0; f < 4; ++f) {
        // The listener emits as soon as the source has moved.
        if (f == 2) input.sources[0] += Vec3(1, 0.5F, 0);
        propagation.step(input);
        memory_bytes.push_back(propagation.statistics().memory_bytes);
    }
    // Rays hit some patches that the search for reached ones has missed; the rest is the log.
    CHECK(memory_bytes[3] < memory_bytes[0] + memory_bytes[0] / 50);
    // Companion: the rows of a source alone are a third of them.
    CHECK(memory_bytes[0] > 100'000'000);
}

TEST_CASE("No memory is mapped while an object moves") {
    Scene scene = load_scene(AULA_SOURCE_DIR "/scenes/door.json").scene;
    scene.simulation.rays = 200;
    Propagation propagation(scene, scene.simulation);
    const FrameInput start = test::static_input(scene, 0);
    const auto memory_bytes = [&](int frame) {
        propagation.step({frame / 30.0, start.sources, start.listeners});
        return propagation.statistics().memory_bytes;
    };
    // The door swings from 3 to 3.5 s. The rows of the listener are free then.
    constexpr int kOpens = 91;
    constexpr int kStillMoves = 104;
    const std::size_t loaded = memory_bytes(0);
    std::size_t before = 0;
    for (int f = 1; f < kOpens; ++f) before = memory_bytes(f);
    // The rest is the log.
    CHECK(loaded > before / 2);
    memory_bytes(kOpens);
    const std::size_t opening = memory_bytes(kOpens + 1);
    std::size_t last = 0;
    for (int f = kOpens + 2; f <= kStillMoves; ++f) last = memory_bytes(f);
    constexpr std::size_t kDeposits_bytes = 1'000'000;
    CHECK(last < opening + kDeposits_bytes);
}

TEST_CASE("The memory limit holds where panels divide many patches") {
    // Half of the rows of this church are those of sides.
    Scene scene = load_scene(AULA_SOURCE_DIR "/scenes/church.json").scene;
    scene.simulation.rays = 200;
    scene.simulation.memory_mb = 50;
    Propagation propagation(scene, scene.simulation);
    std::size_t most = 0;
    for (int f = 0; f < 40; ++f) {
        FrameInput input = test::static_input(scene, 0);
        input.sources[0].x += 0.02F * static_cast<float>(std::max(0, f - 30));
        propagation.step(input);
        most = std::max(most, propagation.statistics().memory_bytes);
    }
    CHECK(static_cast<double>(most) < 1.02e6 * scene.simulation.memory_mb);
    CHECK(static_cast<double>(most) > 0.5e6 * scene.simulation.memory_mb);
}

}  // namespace moves_test
