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
                  const std::vector<EmitterStatus>& listeners, bool turn_of_listeners = false) {
    return plan_emission(sources, listeners, turn_of_listeners, kMax, kBatchRays);
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

TEST_CASE("at rest listeners emit in their turn, up to a twelfth of the rays of each source") {
    constexpr std::uint64_t kFrame = kMax * kBatchRays;
    const auto source_of = [](std::uint64_t frames) {
        return EmitterStatus{false, false, frames * kFrame};
    };
    const auto listener_of = [](std::uint64_t rays) { return EmitterStatus{false, false, rays}; };
    const EmissionPlan first = plan({source_of(24)}, {kNew}, true);
    CHECK(first.sources == Batches{kMax / 2});
    CHECK(first.listeners == Batches{kMax / 2});
    CHECK(plan({source_of(24)}, {kNew}).listeners == Batches{0});  // not its turn
    // Two frames of 24, of which half a frame is emitted now.
    CHECK(plan({source_of(24)}, {listener_of(kFrame * 3 / 2)}, true).listeners ==
          Batches{kMax / 2});
    const EmissionPlan enough = plan({source_of(24)}, {listener_of(kFrame * 3 / 2 + 1)}, true);
    CHECK(enough.listeners == Batches{0});
    CHECK(enough.sources == Batches{kMax});
    // Of two sources that with the fewest rays counts.
    CHECK(plan({source_of(24), source_of(5)}, {kNew}, true).listeners == Batches{0});
    CHECK(plan({source_of(24), source_of(6)}, {kNew}, true).listeners == Batches{kMax / 2});
    // At most sixteen frames.
    CHECK(plan({source_of(1000)}, {listener_of(kFrame * 31 / 2)}, true).listeners ==
          Batches{kMax / 2});
    CHECK(plan({source_of(1000)}, {listener_of(kFrame * 31 / 2 + 1)}, true).listeners ==
          Batches{0});
    // Complete sources emit nothing, the listener does.
    CHECK(plan({kComplete}, {kNew}, true).sources == Batches{0});
    CHECK(plan({kComplete}, {kNew}, true).listeners == Batches{kMax / 2});
    // Of many listeners only that with the fewest rays emits.
    CHECK(plan({source_of(24)}, {listener_of(kFrame), kNew, listener_of(kFrame)}, true).listeners ==
          Batches{0, kMax / 2, 0});
    CHECK(sum(plan({source_of(24)}, std::vector<EmitterStatus>(16, kNew), true).listeners) ==
          kMax / 2);
    // Not after a change, nor without sources.
    CHECK(plan({kMoves}, {kNew}, true).listeners == Batches{kMax});
    CHECK(plan({source_of(24)}, {kMoves}, true).listeners == Batches{0});
    CHECK(plan({source_of(24)}, {kMoves, kNew}, true).listeners == Batches{0, 0});
    CHECK(plan({}, {kNew}, true).listeners == Batches{0});
}

TEST_CASE("a single batch of rays is that of the listener in its turn") {
    const EmitterStatus source{false, false, 12 * kBatchRays};
    const EmissionPlan p = plan_emission({&source, 1}, {&kNew, 1}, true, 1, kBatchRays);
    CHECK(p.sources == Batches{0});
    CHECK(p.listeners == Batches{1});
}
