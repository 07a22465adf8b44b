#include "apps/session/frames/ray_budget.h"

#include <catch2/catch.hpp>
#include <cmath>

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
            rays = rays_within_budget(rays, frame_of(rays), frame_s(rays), 0.02);
        CHECK(rays == Approx(750).margin(1));  // (20 - 5) ms / 20 us, a whole number
    }
}

TEST_CASE("The number of rays is bounded, and constant after a frame without rays") {
    int rays = 1000;
    for (int frame = 0; frame < 100; ++frame)
        rays = rays_within_budget(rays, frame_of(rays), frame_s(rays), 0.001);
    CHECK(rays == 100);
    CHECK(rays_within_budget(1234, FrameStatistics{}, 0.003, 0.02) == 1234);
}
