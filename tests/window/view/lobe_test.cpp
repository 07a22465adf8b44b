#include "apps/window/view/lobe.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "apps/window/view/curves.h"
#include "aula/engine/scene.h"

using namespace aula;

TEST_CASE("The lobe of a turned source has the distances of its pattern") {
    const Vec3 source{2, -1, 1.5F};
    Pose pose;
    pose.yaw_rad = std::numbers::pi_v<float> / 3;
    pose.pitch_rad = 0.4F;
    const glm::mat3 rotation = pose.rotation();
    const Vec3 front = rotation[0];
    const std::size_t band = GENERATE(std::size_t{4}, kAllBands);
    // The pressure of a cardioid is (1 + cos) / 2 of that to the front.
    const auto lines = lobe_lines(Directivity::first_order(0.5F), band, source, rotation, 0.5F);
    REQUIRE(lines.size() > 100);
    float farthest_m = 0;
    for (const auto& line : lines) {
        for (const Vec3& point : line) {
            const float distance_m = glm::distance(point, source);
            farthest_m = std::max(farthest_m, distance_m);
            if (distance_m < 1e-3F) continue;  // to the back
            const float cosine = glm::dot(point - source, front) / distance_m;
            CHECK(distance_m == Approx(0.25F * (1 + cosine)).margin(1e-4));
        }
    }
    CHECK(farthest_m == Approx(0.5F).epsilon(1e-4));
    // Companion: an omnidirectional source has a sphere.
    for (const auto& line : lobe_lines(Directivity(), band, source, rotation, 0.5F))
        CHECK(glm::distance(line[0], source) == Approx(0.5F).epsilon(1e-4));
}
