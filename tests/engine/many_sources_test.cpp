// The cost and the noise of many walking sources.

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <vector>

#include "aula/engine/propagation.h"
#include "tests/support/measure.h"
#include "tests/support/rooms.h"
#include "tests/support/statistics.h"
#include "tests/support/test_scenes.h"

namespace many_sources_test {

using namespace aula;
using aula::test::with;

namespace {

Scene room() {
    return test::grey_room(test::box(Vec3(5, 4, 3)), 0.2F, 0.5F, Vec3(1.2F, 1.1F, 1.5F),
                           Vec3(3.7F, 2.9F, 1.2F));
}

/// Relative standard deviation of the energy over restarts in groups of 20 ms, without the first
/// two, which hold single paths: root mean square.
double deviation(Propagation& propagation, const FrameInput& first, bool listener_walks) {
    constexpr double kGroup_s = 0.02;
    std::vector<std::vector<double>> energies;  // [group][restart]
    for (std::uint64_t seed = 0; seed < 12; ++seed) {
        propagation.restart(seed);
        FrameInput input = first;
        for (int frame = 0; frame < 12; ++frame) {
            for (Vec3& source : input.sources) source.x += 0.02F;
            if (listener_walks) input.listeners[0].y += 0.02F;
            propagation.step(input);
        }
        const EnergyResponse& response = propagation.response(0);
        energies.resize(static_cast<std::size_t>(response.bins.length_s() / kGroup_s) - 2);
        for (std::size_t g = 0; g < energies.size(); ++g) {
            const double begin_s = kGroup_s * static_cast<double>(g + 2);
            energies[g].push_back(test::energy_between(response, begin_s, begin_s + kGroup_s));
        }
    }
    double squares = 0;
    for (const std::vector<double>& restarts : energies) {
        const test::Estimate e = test::estimate(restarts);
        squares += std::pow(e.standard_error / e.mean, 2) * static_cast<double>(restarts.size());
    }
    return std::sqrt(squares / static_cast<double>(energies.size()));
}

}  // namespace

TEST_CASE("the work of 16 walking sources is at most three times that of one") {
    const Scene one = room();
    const auto last_frame = [&](std::size_t sources) {
        Scene scene = one;
        scene.sources.resize(sources, scene.sources[0]);
        Propagation propagation(scene, with(scene, Estimator::patch, 0.3F));
        FrameInput input = test::static_input(scene);
        for (int frame = 0; frame < 4; ++frame) {
            for (std::size_t s = 0; s < sources; ++s)
                input.sources[s].x += 0.02F * (s % 2 == 0 ? 1.0F : -1.0F);
            propagation.step(input);
        }
        return propagation.statistics();
    };
    const FrameStatistics alone = last_frame(1);
    const FrameStatistics many = last_frame(16);
    CHECK(many.segments > alone.segments);
    CHECK(many.segments < 3 * alone.segments);
    // Hits of one patch are joined: with a quarter of the rays more than a quarter remain.
    CHECK(many.summed_bins > 4 * alone.summed_bins);
    CHECK(many.summed_bins < 8 * alone.summed_bins);
}

TEST_CASE("the noise of each of 16 walking sources is at most twice that of one") {
    Scene scene = room();
    const int rays = GENERATE(300, 1000);
    const bool listener_walks = GENERATE(false, true);
    const auto deviation_of = [&](std::size_t sources) {
        scene.sources.resize(1);
        scene.sources.resize(sources, scene.sources[0]);
        Simulation simulation = with(scene, Estimator::patch, 0.3F);
        simulation.rays = rays;
        Propagation propagation(scene, simulation);
        return deviation(propagation, test::static_input(scene), listener_walks);
    };
    const double alone = deviation_of(1);
    const double many = deviation_of(16);
    CAPTURE(rays, listener_walks, alone, many);
    CHECK(alone > 0);
    // A quarter of the gather rays has twice their noise, to which that of the emitters is added.
    CHECK(many < 2 * alone);
}

}  // namespace many_sources_test
