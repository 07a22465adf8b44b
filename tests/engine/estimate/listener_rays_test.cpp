#include <catch2/catch.hpp>

#include "aula/engine/propagation.h"
#include "tests/support/measure.h"
#include "tests/support/rooms.h"

using namespace aula;

TEST_CASE("rays from listeners only give the same energies, and sources need no memory") {
    constexpr std::size_t kSources = 4;
    Scene scene =
        test::grey_room(test::box(Vec3(5, 4, 3)), 0.3F, 1, Vec3(1, 1, 1), Vec3(4, 3, 1.5F));
    const Source source = scene.sources[0];
    while (scene.sources.size() < kSources) {
        scene.sources.push_back(source);
        scene.sources.back().position.y += 0.5F * static_cast<float>(scene.sources.size());
    }
    const Simulation simulation = test::with(scene, Estimator::patch, 0.3F);
    Propagation both(scene, simulation);
    Propagation listeners(scene, simulation);
    listeners.emit_from_listeners();
    for (int frame = 0; frame < 40; ++frame) {
        both.step(test::static_input(scene));
        listeners.step(test::static_input(scene));
    }
    // The mean of 40 frames of 1000 rays: over seeds the ratio of both totals spreads by less than
    // 1 %.
    for (std::size_t s = 0; s < kSources; ++s)
        CHECK(test::total(listeners.response(s)) ==
              Approx(test::total(both.response(s))).epsilon(0.05));
    CHECK(listeners.statistics().memory_bytes < both.statistics().memory_bytes / 2);
    // A source that is added needs none either.
    const std::size_t before = listeners.statistics().memory_bytes;
    listeners.add_source({.position = {2, 2, 2}});
    FrameInput input = test::static_input(scene);
    input.sources.emplace_back(2, 2, 2);
    input.source_rotations.emplace_back(1);
    for (int frame = 0; frame < 20; ++frame) listeners.step(input);
    CHECK(test::total(listeners.response(kSources)) > 0);
    CHECK(listeners.statistics().memory_bytes < before + before / 10);
}
