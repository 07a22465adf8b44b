#include "engine/estimate/response_length.h"

#include <array>
#include <catch2/catch.hpp>
#include <vector>

#include "aula/engine/propagation.h"
#include "tests/support/test_scenes.h"

using namespace aula;

namespace {

/// A room of 5 x 4 x 3 m at the origin and one of the same size 10 m away along x, closed.
Scene two_rooms(float absorption, float other_absorption) {
    Scene scene = test::small_room();
    scene.materials = {{"wall", Bands::filled(absorption), Bands::filled(0.5F)},
                       {"other", Bands::filled(other_absorption), Bands::filled(0.5F)}};
    scene.objects.push_back(scene.objects[0]);
    scene.objects[1].translation = Vec3(10, 0, 0);
    for (std::uint32_t& material : scene.objects[1].triangle_materials) material = 1;
    scene.simulation.ir_length_s.reset();
    return scene;
}

double length_s(const Scene& scene, std::span<const Vec3> receivers = {}) {
    return Propagation(scene, scene.simulation, 1, receivers).response_length_s();
}

}  // namespace

TEST_CASE("The default length of the responses is the same for any number of threads") {
    const Scene scene = two_rooms(0.15F, 0.3F);
    const RayScene rays(scene);
    const std::array<Vec3, 2> sources{Vec3(1, 1, 1), Vec3(4, 3, 2)};
    const std::array<Vec3, 1> listeners{Vec3(2, 3, 1)};
    std::vector<double> lengths;
    for (const int threads : {1, 2, 5}) {
        WorkerPool workers(threads);
        lengths.push_back(
            sounding_length_s(rays, scene.medium, 0, sources, listeners, 10, 7, workers));
    }
    CHECK(lengths[0] > 0.4);
    CHECK(lengths[1] == lengths[0]);  // exact: the same particles, added in the same order
    CHECK(lengths[2] == lengths[0]);
}

TEST_CASE("The default length counts the rooms of all receivers") {
    const Scene scene = two_rooms(0.5F, 0.1F);
    const std::array<Vec3, 2> receivers{Vec3(2, 3, 1), Vec3(12, 3, 1)};
    const double here_s = length_s(scene, std::span(receivers).first(1));
    CHECK(here_s < 0.4);
    CHECK(length_s(scene) == here_s);
    // Sound does not reach the other room; where a door opens later, it decays as there.
    CHECK(length_s(scene, receivers) > 2.5 * here_s);
}

TEST_CASE("A limit of the reflection order shortens the responses") {
    Scene scene = two_rooms(0.1F, 0.1F);
    const double all_s = length_s(scene);
    scene.simulation.order = 5;
    // Six segments of 2.55 m in the mean last for 45 ms: the shortest length, in bins of 8 ms.
    CHECK(length_s(scene) == Approx(0.3).margin(0.008));
    CHECK(all_s > 3 * length_s(scene));
}

TEST_CASE("The default length without a source is that of sources that come later") {
    // The companion is the room of the test above, whose length without an end in it is 0.3 s.
    const Scene scene = two_rooms(0.1F, 0.1F);
    Scene later = scene;
    later.sources.clear();
    const double expected_s = length_s(scene);
    // The decay of a place and of the whole room: both have the slope of the room.
    CHECK(length_s(later) == Approx(expected_s).epsilon(0.1));
    CHECK(expected_s > 1);
}
