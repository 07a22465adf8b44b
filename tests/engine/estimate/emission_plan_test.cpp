#include "engine/estimate/emission_plan.h"

#include <catch2/catch.hpp>
#include <numeric>

using namespace aula;

namespace {

constexpr int kMost = 8;
constexpr int kBatchRays = 128;
constexpr EmitterStatus kMoves{true, false, 4000};
constexpr EmitterStatus kStands{false, false, 4000};
constexpr EmitterStatus kNew{false, false, 0};
constexpr EmitterStatus kComplete{false, true, 1 << 20};

EmissionPlan plan(const std::vector<EmitterStatus>& sources,
                  const std::vector<EmitterStatus>& listeners) {
    return plan_emission(sources, listeners, kMost, kBatchRays);
}

int sum(const std::vector<int>& batches) {
    return std::accumulate(batches.begin(), batches.end(), 0);
}

using Batches = std::vector<int>;

}  // namespace

TEST_CASE("sources that stand send rays themselves, wherever the listener goes") {
    for (const EmitterStatus& listener : {kMoves, kStands, kNew}) {
        const EmissionPlan p = plan({kStands}, {listener});
        CHECK(p.sources == Batches{kMost});
        CHECK(p.listeners == Batches{0});
    }
}

TEST_CASE("a listener that stands sends the rays for sources that move") {
    const EmissionPlan one = plan({kMoves}, {kStands});
    CHECK(one.sources == Batches{0});
    CHECK(one.listeners == Batches{kMost});
    // A source that stands goes on by itself.
    const EmissionPlan two = plan({kMoves, kStands}, {kStands});
    CHECK(two.sources == Batches{0, kMost});
    CHECK(two.listeners == Batches{kMost});
    // Another listener who moves has no use for the first one's rays.
    const EmissionPlan apart = plan({kMoves}, {kStands, kMoves});
    CHECK(apart.sources == Batches{kMost});
    CHECK(apart.listeners == Batches{kMost, 0});
}

TEST_CASE("where both ends move the fewer of them send rays") {
    CHECK(plan({kMoves}, {kMoves}).sources == Batches{kMost});
    CHECK(plan({kMoves}, {kMoves}).listeners == Batches{0});
    const EmissionPlan crowd = plan({kMoves, kMoves, kMoves}, {kMoves});
    CHECK(crowd.sources == Batches{0, 0, 0});
    CHECK(crowd.listeners == Batches{kMost});
    CHECK(plan({kMoves, kMoves}, {kMoves, kMoves}).sources == Batches{kMost, kMost});
}

TEST_CASE("who has gathered enough sends nothing") {
    CHECK(plan({kComplete}, {kStands}).sources == Batches{0});
    CHECK(plan({kMoves}, {kComplete}).listeners == Batches{0});
    CHECK(plan({kMoves}, {kComplete}).sources == Batches{0});
}

TEST_CASE("sources that stand share the rays of two, who has least first") {
    const EmissionPlan p = plan(std::vector<EmitterStatus>(32, kStands), {kMoves});
    CHECK(sum(p.sources) == 2 * kMost);
    const EmissionPlan uneven =
        plan({kStands, {false, false, 1000}, {false, false, 100}}, {kMoves});
    CHECK(sum(uneven.sources) == 2 * kMost);
    CHECK(uneven.sources[2] == kMost);
    CHECK(uneven.sources[1] == kMost);
    // Whoever moves has all that one may send.
    std::vector<EmitterStatus> one_moves(32, kStands);
    one_moves[7] = kMoves;
    const EmissionPlan moving = plan(one_moves, {kMoves});
    CHECK(moving.sources[7] == kMost);
    CHECK(sum(moving.sources) == 3 * kMost);
}

TEST_CASE("no new source waits for its first rays") {
    const EmissionPlan p = plan(std::vector<EmitterStatus>(100, kNew), {kStands});
    CHECK(p.sources == Batches(100, 1));
}
