#include "apps/room/frames/ray_budget.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <string>

using namespace aula;

namespace {

/// A machine on which a ray takes 20 us and everything else 5 ms.
FrameStatistics frame_of(int rays) {
    FrameStatistics statistics;
    statistics.trace_s = 15e-6 * rays;
    statistics.cache_s = 5e-6 * rays;
    statistics.gather_s = 0.004;
    return statistics;
}

double frame_s(int rays) { return 20e-6 * rays + 0.005; }

}  // namespace

TEST_CASE("The number of rays converges to frames that take their allowed time") {
    for (const int start : {100, 1000, 20000}) {
        int rays = start;
        for (int frame = 0; frame < 100; ++frame)
            rays = rays_within_budget(rays, frame_of(rays), frame_s(rays), 0.02, 1);
        CHECK(rays == Approx(750).margin(1));  // (20 - 5) ms / 20 us, a whole number
    }
}

TEST_CASE("The number of rays is bounded, and constant after a frame without rays") {
    int rays = 1000;
    for (int frame = 0; frame < 100; ++frame)
        rays = rays_within_budget(rays, frame_of(rays), frame_s(rays), 0.001, 1);
    CHECK(rays == 100);
    CHECK(rays_within_budget(1234, FrameStatistics{}, 0.003, 0.02, 1) == 1234);
}

TEST_CASE("The fewest rays are those of all sources together, down to 25 of each") {
    CHECK(fewest_rays(0) == 100);
    CHECK(fewest_rays(1) == 100);
    CHECK(fewest_rays(2) == 50);
    CHECK(fewest_rays(8) == 25);
    CHECK(rays_within_work(200, FrameStatistics{.segments = 1'000'000}, 0, 2) == 50);
    CHECK(rays_within_budget(26, frame_of(26), frame_s(26), 0.001, 8) == 25);
}

TEST_CASE("Counted time does not depend on clocks, and limits the rays of a frame") {
    const auto counted = [](int rays) {
        FrameStatistics statistics;
        statistics.segments = 100 * static_cast<std::uint64_t>(rays);
        statistics.summed_bins = 1'000'000;
        statistics.trace_s = 1e3;
        return statistics;
    };
    FrameStatistics untimed = counted(500);
    untimed.trace_s = 0;
    CHECK(counted_s(counted(500)) == counted_s(untimed));
    CHECK(counted_s(counted(1000)) > counted_s(counted(500)));
    FrameStatistics mirrored = counted(500);
    mirrored.image_reflections = 10'000;
    CHECK(counted_s(mirrored) > counted_s(counted(500)));

    const double wanted_s = counted_s(counted(400));
    for (const int start : {100, 1000}) {
        int rays = start;
        for (int frame = 0; frame < 100; ++frame)
            rays = rays_within_work(rays, counted(rays), wanted_s, 1);
        CHECK(rays == Approx(400).margin(1));  // a whole number
    }
    CHECK(rays_within_work(1000, counted(1000), 1, 1) == 1000);
    CHECK(rays_within_work(200, counted(200), 0, 1) == 100);
    CHECK(rays_within_work(200, FrameStatistics{}, 1, 1) == 220);
    CHECK(allowed_s(Quality::normal, 0.1) == Approx(0.15));
    CHECK(allowed_s(Quality::draft, 0.1) == Approx(0.0375));
}

TEST_CASE("A quality means the same share of time offline and live") {
    CHECK(std::isinf(allowed_s(Quality::fine, 0.1)));
    CHECK(rays_within_work(1000, frame_of(1000), allowed_s(Quality::fine, 0.1), 1) == 1000);
    Simulation simulation;
    CHECK(live_rays(simulation) == Simulation::kRays);
    simulation.quality = Quality::fine;
    CHECK(live_rays(simulation) == Simulation::kRays);
    simulation.quality = Quality::draft;
    CHECK(live_rays(simulation) / double{Simulation::kRays} ==
          allowed_s(Quality::draft, 1) / allowed_s(Quality::normal, 1));
    simulation.rays = 321;
    CHECK(live_rays(simulation) == 321);
}

TEST_CASE("A rendering that takes longer than its quality allows with the fewest rays says so") {
    Simulation simulation;
    const auto text = [&](int rays, double counted_s) {
        return over_budget_text(simulation, 8, rays, counted_s);
    };
    CHECK(text(25, 0.05).empty());
    CHECK(text(26, 1).empty());
    CHECK(text(25, 0.2).find("about 4.0 s of two processors with 8 sources and 25 rays") !=
          std::string::npos);
    CHECK(text(25, 0.2).find("--ir-length") != std::string::npos);
    simulation.quality = Quality::draft;
    CHECK_FALSE(text(25, 0.05).empty());
    simulation.quality = Quality::fine;
    CHECK(text(25, 1).empty());
    simulation.quality = Quality::normal;
    simulation.rays = 100;
    CHECK(text(25, 1).empty());
}
