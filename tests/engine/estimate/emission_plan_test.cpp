#include "engine/estimate/emission_plan.h"

#include <catch2/catch.hpp>
#include <numeric>

using namespace aula;

namespace {

constexpr int kMax = 8;
constexpr int kBatchRays = 128;
constexpr EmitterStatus kMoves{true, false, 4000};
constexpr EmitterStatus kStatic{false, false, 4000};
constexpr EmitterStatus kNew{false, false, 0};
constexpr EmitterStatus kComplete{false, true, 1 << 20};

EmissionPlan plan(const std::vector<EmitterStatus>& sources,
                  const std::vector<EmitterStatus>& listeners) {
    return plan_emission(sources, listeners, kMax, kBatchRays);
}

int sum(const std::vector<int>& batches) {
    return std::accumulate(batches.begin(), batches.end(), 0);
}

using Batches = std::vector<int>;

}  // namespace

TEST_CASE("static sources emit rays for any movement of the listener") {
    for (const EmitterStatus& listener : {kMoves, kStatic, kNew}) {
        const EmissionPlan p = plan({kStatic}, {listener});
        CHECK(p.sources == Batches{kMax});
        CHECK(p.listeners == Batches{0});
    }
}

TEST_CASE("a static listener emits the rays for moving sources") {
    const EmissionPlan one = plan({kMoves}, {kStatic});
    CHECK(one.sources == Batches{0});
    CHECK(one.listeners == Batches{kMax});
    // A static source continues to emit.
    const EmissionPlan two = plan({kMoves, kStatic}, {kStatic});
    CHECK(two.sources == Batches{0, kMax});
    CHECK(two.listeners == Batches{kMax});
    // A second, moving listener cannot use the rays of the first one.
    const EmissionPlan apart = plan({kMoves}, {kStatic, kMoves});
    CHECK(apart.sources == Batches{kMax});
    CHECK(apart.listeners == Batches{kMax, 0});
}

TEST_CASE("if both ends move, the end with fewer emitters emits rays") {
    CHECK(plan({kMoves}, {kMoves}).sources == Batches{kMax});
    CHECK(plan({kMoves}, {kMoves}).listeners == Batches{0});
    const EmissionPlan many_moving = plan({kMoves, kMoves, kMoves}, {kMoves});
    CHECK(many_moving.sources == Batches{0, 0, 0});
    CHECK(many_moving.listeners == Batches{kMax});
    CHECK(plan({kMoves, kMoves}, {kMoves, kMoves}).sources == Batches{kMax, kMax});
}

TEST_CASE("an emitter with enough rays emits nothing") {
    CHECK(plan({kComplete}, {kStatic}).sources == Batches{0});
    CHECK(plan({kMoves}, {kComplete}).listeners == Batches{0});
    CHECK(plan({kMoves}, {kComplete}).sources == Batches{0});
}

TEST_CASE("static sources share the rays of two, fewest rays first") {
    const EmissionPlan p = plan(std::vector<EmitterStatus>(32, kStatic), {kMoves});
    CHECK(sum(p.sources) == 2 * kMax);
    const EmissionPlan uneven =
        plan({kStatic, {false, false, 1000}, {false, false, 100}}, {kMoves});
    CHECK(sum(uneven.sources) == 2 * kMax);
    CHECK(uneven.sources[2] == kMax);
    CHECK(uneven.sources[1] == kMax);
    // A moving emitter emits the maximum.
    std::vector<EmitterStatus> one_moves(32, kStatic);
    one_moves[7] = kMoves;
    const EmissionPlan moving = plan(one_moves, {kMoves});
    CHECK(moving.sources[7] == kMax);
    CHECK(sum(moving.sources) == 3 * kMax);
}

TEST_CASE("a new source emits rays in its first frame") {
    const EmissionPlan p = plan(std::vector<EmitterStatus>(100, kNew), {kStatic});
    CHECK(p.sources == Batches(100, 1));
}
