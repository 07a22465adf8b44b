#include "engine/estimate/gather_plan.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "engine/estimate/final_gather.h"

namespace gather_plan_test {

using namespace aula;

namespace {

constexpr int kRays = 1000;         // of an emitter in a frame
constexpr std::size_t kSource = 0;  // emitters of the only pair
constexpr std::size_t kListener = 1;

constexpr PairStatus kMoving{kSource, kListener, 20, false, false};
constexpr PairStatus kResting{kSource, kListener, 49, true, false};
constexpr PairStatus kStarting{kSource, kListener, 49, false, true};

GatherPlan plan(const PairStatus& pair, std::uint64_t of_source, std::uint64_t of_listener,
                int rays = kRays, bool scene_moved = false) {
    const std::vector<char> wanted{1};
    const std::vector<std::uint64_t> emitted{of_source, of_listener};
    return plan_gather(std::span(&pair, 1), wanted, emitted, rays, scene_moved, 1);
}

}  // namespace

TEST_CASE(
    "a pair in motion gathers at least the rays of an emitter, of few ones several times as many") {
    const auto gathered = [](int rays) {
        return plan(kMoving, 50'000, 0, rays).at[kListener].rays;
    };
    int last = 0;
    for (const int rays : {16, 50, 100, 200, 300, 500, 1000, 2000, 5000, 20'000, 200'000}) {
        CAPTURE(rays);
        const int now = gathered(rays);
        CHECK(now >= last);
        CHECK(now >= std::min(rays, kMostGatherRays));
        CHECK(now <= kMostGatherRays);
        last = now;
    }
    // Live playback has some hundred rays. Their gather costs more than they do, but not ten times.
    for (const int rays : {100, 200, 300}) {
        CAPTURE(rays);
        CHECK(gathered(rays) > 2 * rays);
        CHECK(gathered(rays) < 10 * rays);
    }
    CHECK(last == kMostGatherRays);
}

TEST_CASE("after a movement of the scene every pair gathers the most rays") {
    for (const int rays : {100, 1000, 10'000}) {
        CAPTURE(rays);
        CHECK(plan(kMoving, 50'000, 0, rays, true).at[kListener].rays == kMostGatherRays);
        CHECK(plan(kStarting, 0, 50'000, rays, true).at[kSource].rays == kMostGatherRays);
    }
}

TEST_CASE("the first gather of a source that starts to move is cheaper") {
    for (const int rays : {200, 300, 1000, 2000}) {
        CAPTURE(rays);
        const int first = plan(kStarting, 0, 50'000, rays).at[kSource].rays;
        const int later = plan(kMoving, 0, 50'000, rays).at[kSource].rays;
        CHECK(first < later);
        CHECK(2 * first >= later);
    }
}

TEST_CASE("gathers at rest follow the rays of the cells per frame of the mean") {
    // The error of the mean is that of both ends. At equal costs a gather has about as many rays as
    // the cells gain in a frame.
    const auto gathered = [](std::uint64_t emitted) {
        return plan(kResting, emitted, 0).at[kListener].rays;
    };
    for (const std::uint64_t per_frame : {400U, 800U, 1600U}) {
        CAPTURE(per_frame);
        const int rays = gathered(50 * per_frame);
        CHECK(rays > static_cast<int>(per_frame) / 2);
        CHECK(rays < 2 * static_cast<int>(per_frame));
    }
    CHECK(gathered(1000) > 0);
    // Not more than in motion, however many rays the cells have.
    CHECK(gathered(5'000'000) == plan(kMoving, 50'000, 0).at[kListener].rays);
}

TEST_CASE("each end has the share of its rays in the response and in the gathers") {
    const GatherPlan p = plan(kMoving, 30'000, 10'000);
    CHECK(p.shares[0].source == Approx(0.75));
    CHECK(p.shares[0].listener == Approx(0.25));
    // The rays of the source are gathered at the listener.
    const int of_one = plan(kMoving, 40'000, 0).at[kListener].rays;
    CHECK(p.at[kListener].rays == Approx(0.75 * of_one).margin(FinalGather::kBatchRays));
    CHECK(p.at[kSource].rays == Approx(0.25 * of_one).margin(FinalGather::kBatchRays));
    CHECK(p.at[kListener].pairs == std::vector<std::size_t>{0});
    CHECK(p.at[kSource].pairs == std::vector<std::size_t>{0});
}

TEST_CASE("an end with hardly any rays is not gathered") {
    const GatherPlan few = plan(kMoving, 95'000, 5'000);
    CHECK(few.shares[0].source == 1);
    CHECK(few.shares[0].listener == 0);
    CHECK(few.at[kSource].pairs.empty());
    CHECK(few.at[kListener].rays == plan(kMoving, 100'000, 0).at[kListener].rays);
    CHECK_FALSE(plan(kMoving, 80'000, 20'000).at[kSource].pairs.empty());
    const GatherPlan none = plan(kMoving, 0, 0);
    CHECK(none.at[kSource].pairs.empty());
    CHECK(none.at[kListener].pairs.empty());
}

TEST_CASE("the gather at one listener serves all sources") {
    const std::vector<PairStatus> pairs{{0, 2, 49, true, false}, {1, 2, 3, false, false}};
    const std::vector<char> wanted{1, 1};
    const std::vector<std::uint64_t> emitted{50'000, 4'000, 0};
    const GatherPlan p = plan_gather(pairs, wanted, emitted, kRays, false, 0);
    CHECK(p.at[2].pairs == std::vector<std::size_t>{0, 1});
    CHECK(p.at[2].rays == plan(kMoving, 50'000, 0).at[kListener].rays);
    const std::vector<char> first{1, 0};
    CHECK(plan_gather(pairs, first, emitted, kRays, false, 0).at[2].pairs ==
          std::vector<std::size_t>{0});
}

TEST_CASE("n pairs in motion have 1 / sqrt(n) of the gather rays of one, each") {
    const auto rays_of_each = [](std::size_t moving, std::size_t resting, bool scene_moved) {
        std::vector<PairStatus> pairs;
        const std::size_t listener = moving + resting;
        for (std::size_t s = 0; s < listener; ++s) pairs.push_back(s < moving ? kMoving : kResting);
        for (std::size_t s = 0; s < listener; ++s) {
            pairs[s].source = s;
            pairs[s].listener = listener;
        }
        // The rays of the listener are gathered at the sources.
        std::vector<std::uint64_t> emitted(listener + 1, 0);
        emitted[listener] = 100'000;
        const std::vector<char> wanted(pairs.size(), 1);
        const GatherPlan p = plan_gather(pairs, wanted, emitted, kRays, scene_moved, 1);
        return p.at[0].rays;
    };
    const int one = rays_of_each(1, 0, false);
    CHECK(rays_of_each(1, 20, false) == one);
    for (const bool moved : {false, true}) {
        const int alone = rays_of_each(1, 0, moved);
        for (const std::size_t n : {4U, 16U, 64U}) {
            const double wanted = alone / std::sqrt(static_cast<double>(n));
            CHECK(rays_of_each(n, 0, moved) >= wanted);
            CHECK(rays_of_each(n, 5, moved) < wanted + FinalGather::kBatchRays);
        }
    }
}

TEST_CASE("pairs share the rays of those emitters alone that they have in common") {
    // Four sources and four listeners walk, and the listeners emit.
    std::vector<PairStatus> pairs(16, kMoving);
    for (std::size_t i = 0; i < 16; ++i) {
        pairs[i].source = i / 4;
        pairs[i].listener = 4 + i % 4;
    }
    const std::vector<char> wanted(16, 1);
    const std::vector<std::uint64_t> emitted{0, 0, 0, 0, 1000, 1000, 1000, 1000};
    const auto rays = [&](std::size_t emitters) {
        return plan_gather(pairs, wanted, emitted, kRays, false, emitters).at[0].rays;
    };
    CHECK(rays(16) == plan(kMoving, 0, 1000).at[kSource].rays);
    CHECK(rays(4) == rays(16) / 2);
    CHECK(rays(1) == rays(16) / 4);
    CHECK(rays(0) == rays(1));  // emitters at rest share one budget
}

TEST_CASE("gathers of few rays have a batch") {
    CHECK(plan(kResting, 50'000, 0, 16).at[kListener].rays == FinalGather::kBatchRays);
}

TEST_CASE("pairs at rest are gathered two in a frame, those in motion in every frame") {
    const std::vector<PairStatus> pairs{kResting, kResting, kMoving, kResting, kResting};
    std::vector<int> gathered(pairs.size(), 0);
    for (std::uint64_t frame = 0; frame < 5; ++frame) {
        const std::vector<char> wanted = pairs_to_gather(pairs, frame);
        for (std::size_t i = 0; i < pairs.size(); ++i) gathered[i] += wanted[i];
    }
    CHECK(gathered == std::vector<int>{2, 2, 5, 2, 2});
    CHECK(pairs_to_gather({}, 7).empty());
}

TEST_CASE("a single pair at rest is gathered in every frame") {
    for (std::uint64_t frame = 0; frame < 3; ++frame)
        CHECK(pairs_to_gather(std::span(&kResting, 1), frame) == std::vector<char>{1});
}

}  // namespace gather_plan_test
