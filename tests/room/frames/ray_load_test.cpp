#include "apps/room/frames/ray_load.h"

#include <catch2/catch.hpp>
#include <utility>
#include <vector>

using namespace aula;

TEST_CASE("Rays of a room fall until frames are in time, which is reported once, and its end") {
    constexpr double kPeriod_s = 1.0 / 30;
    std::vector<std::pair<int, int>> reports;
    RayLoad load([&](int rays, int wanted) { reports.emplace_back(rays, wanted); });
    int rays = 1000;
    const auto play = [&](double ray_s, double seconds) {
        for (double s = 0; s < seconds; s += kPeriod_s)
            rays = load.next(1000, ray_s * rays, kPeriod_s);
    };
    play(10e-6, 30);
    CHECK(rays == 1000);
    CHECK(reports.empty());

    play(100e-6, 4);  // 333 rays would fill the period
    CHECK(rays > 200);
    CHECK(rays < 300);
    CHECK(reports.empty());
    play(100e-6, 60);
    REQUIRE(reports.size() == 1);
    CHECK(reports[0].first < 300);
    CHECK(reports[0].second == 1000);

    play(10e-6, 300);
    CHECK(rays == 1000);
    REQUIRE(reports.size() == 2);
    CHECK(reports[1] == std::pair(1000, 1000));
}
