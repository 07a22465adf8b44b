#include "apps/room/live/reduction_reporter.h"

#include <catch2/catch.hpp>

using namespace aula;

namespace {

PlayStatus status_of(int rays, double length_s) {
    PlayStatus status;
    status.rays = rays;
    status.full_rays = 1000;
    status.response_length_s = length_s;
    status.full_response_length_s = 3;
    return status;
}

}  // namespace

TEST_CASE("The report of a reduced load names the reduced values") {
    CHECK(reduction_text(status_of(1000, 3)).empty());
    CHECK(reduction_text(status_of(300, 3)) == "keeps up with 300 of 1000 rays");
    CHECK(reduction_text(status_of(1000, 1.2)) == "keeps up with 1.2 of 3.0 s of response");
    CHECK(reduction_text(status_of(300, 1.2)) ==
          "keeps up with 300 of 1000 rays and 1.2 of 3.0 s of response");
}

TEST_CASE("A reduction is reported once when it is stable, and again for a shorter response") {
    ReductionReporter reporter("--rays and --ir-length set them");
    CHECK_FALSE(reporter.take(status_of(1000, 3), 1));
    CHECK_FALSE(reporter.take(status_of(700, 3), 2));
    CHECK_FALSE(reporter.take(status_of(400, 3), 3));
    const auto text = reporter.take(status_of(300, 3), 8.5);
    REQUIRE(text);
    CHECK(text->find("300 of 1000 rays") != std::string::npos);
    CHECK(text->find("--rays") != std::string::npos);
    for (double now_s = 9; now_s < 100; ++now_s)
        CHECK_FALSE(reporter.take(status_of(now_s < 50 ? 360 : 300, 3), now_s));
    PlayStatus shorter = status_of(300, 1.5);
    CHECK_FALSE(reporter.take(shorter, 101));
    shorter.preparing = true;
    CHECK_FALSE(reporter.take(shorter, 108));
    shorter.preparing = false;
    CHECK(reporter.take(shorter, 109));
    CHECK_FALSE(reporter.take(shorter, 120));
}

TEST_CASE("A response that grows is not reported, one that stops growing is") {
    ReductionReporter growing("");
    for (int step = 0; step < 4; ++step)
        CHECK_FALSE(growing.take(status_of(1000, 1 + 0.5 * step), 5 * step));
    CHECK_FALSE(growing.take(status_of(1000, 3), 20));
    ReductionReporter stopped("");
    CHECK_FALSE(stopped.take(status_of(1000, 1), 0));
    CHECK_FALSE(stopped.take(status_of(1000, 1.5), 5));
    CHECK(stopped.take(status_of(1000, 1.5), 12));
    CHECK_FALSE(stopped.take(status_of(1000, 2), 20));
}

TEST_CASE("Frames that are late are reported once, also where nothing may be reduced") {
    for (const int rays : {1000, 100}) {
        INFO(rays << " of 1000 rays");
        PlayStatus status = status_of(rays, 3);
        status.frame_period_ms = 100.0 / 3;
        ReductionReporter late("");
        ReductionReporter in_time("");
        int reports = 0;
        std::string text;
        for (int second = 0; second < 60; ++second) {
            status.frames += 10;
            if (const auto report = in_time.take(status, second))
                CHECK(report->find("frames per second") == std::string::npos);
        }
        for (int second = 0; second < 60; ++second) {
            status.frames += 10;
            status.late_frames += 9;
            if (const auto report = late.take(status, second)) {
                text = *report;
                ++reports;
            }
        }
        CHECK(reports == 1);
        CHECK(text.find("computes 10.0 of 30 frames per second") == 0);
        CHECK((text.find("100 of 1000 rays") != std::string::npos) == (rays == 100));
        CHECK(text.find("fewer sources") != std::string::npos);
    }
}
