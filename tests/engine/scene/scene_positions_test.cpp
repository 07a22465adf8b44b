#include "engine/scene/scene_positions.h"

#include <catch2/catch.hpp>

using aula::Vec3;

TEST_CASE("The positions of a scene are those of sources and listener, or of their keyframes") {
    aula::Scene scene;
    scene.sources.resize(2);
    scene.sources[0].position = {1, 0, 0};
    scene.sources[1].position = {2, 0, 0};
    scene.listener.pose.position = {3, 0, 0};
    CHECK(aula::scene_positions(scene) == std::vector<Vec3>{{1, 0, 0}, {2, 0, 0}, {3, 0, 0}});
    scene.sources[0].path = {{{0, {{4, 0, 0}}}, {1, {{5, 0, 0}}}}, true};
    scene.listener.path = {{{0, {{6, 0, 0}}}}, false};
    CHECK(aula::scene_positions(scene) ==
          std::vector<Vec3>{{4, 0, 0}, {5, 0, 0}, {2, 0, 0}, {6, 0, 0}});
}
