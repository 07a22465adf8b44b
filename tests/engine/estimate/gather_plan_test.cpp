#include "engine/estimate/gather_plan.h"

#include <catch2/catch.hpp>
#include <cmath>

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

TEST_CASE("a pair in motion gathers half as many rays again as an emitter sends") {
    CHECK(plan(kMoving, 50'000, 0).at[kListener].rays == 1536);  // a multiple of 128
    CHECK(plan(kMoving, 50'000, 0, 200).at[kListener].rays == 768);
    CHECK(plan(kMoving, 50'000, 0, 100).at[kListener].rays == 512);
    CHECK(plan(kMoving, 50'000, 0, 10'000).at[kListener].rays == 4096);
    CHECK(plan(kMoving, 50'000, 0, 100, true).at[kListener].rays == 4096);
}

TEST_CASE("the first gather of a source that starts to move is cheaper") {
    CHECK(plan(kStarting, 0, 50'000).at[kSource].rays == 1024);
    CHECK(plan(kStarting, 0, 50'000, 100).at[kSource].rays == 512);
    CHECK(plan(kStarting, 0, 50'000, kRays, true).at[kSource].rays == 4096);
}

TEST_CASE("gathers at rest follow the rays of the cells per frame of the mean") {
    CHECK(plan(kResting, 50'000, 0).at[kListener].rays == 768);  // 0.75 * 50'000 / 50
    CHECK(plan(kResting, 5'000, 0).at[kListener].rays == 128);
    CHECK(plan(kResting, 5'000'000, 0).at[kListener].rays == 1536);
}

TEST_CASE("each end has the share of its rays in the response and in the gathers") {
    const GatherPlan p = plan(kMoving, 30'000, 10'000);
    CHECK(p.shares[0].source == Approx(0.75));
    CHECK(p.shares[0].listener == Approx(0.25));
    // The rays of the source are gathered at the listener.
    CHECK(p.at[kListener].rays == 1152);  // 0.75 * 1500, a multiple of 128
    CHECK(p.at[kSource].rays == 384);
    CHECK(p.at[kListener].pairs == std::vector<std::size_t>{0});
    CHECK(p.at[kSource].pairs == std::vector<std::size_t>{0});
}

TEST_CASE("an end with less than a tenth of the rays is not gathered") {
    const GatherPlan few = plan(kMoving, 95'000, 5'000);
    CHECK(few.shares[0].source == 1);
    CHECK(few.shares[0].listener == 0);
    CHECK(few.at[kSource].pairs.empty());
    CHECK(few.at[kListener].rays == 1536);
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
    CHECK(p.at[2].rays == 1536);  // those of the pair in motion
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
            CHECK(rays_of_each(n, 5, moved) < wanted + 128);  // a batch
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
    CHECK(plan(kResting, 50'000, 0, 16).at[kListener].rays == 128);
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
