#include "apps/window/view/standing_waves.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/support/rooms.h"

namespace standing_waves_test {

using namespace aula;

TEST_CASE("The picture of a standing wave has its node in the middle, and ends at the walls") {
    const Vec3 size(5, 4, 3);
    const Vec3 source(0.3F, 2, 1.5F);
    Scene scene = test::grey_room(test::box(size), 0.02F, 0.1F, source, size / 2.0F);
    scene.simulation = {};
    // A room that is played with rays alone has modes, too.
    scene.simulation.waves_hz = 0;
    Bounds bounds;
    bounds.min = Vec3(-1);
    bounds.max = Vec3(6, 5, 4);
    const StandingWaves waves(scene, bounds, 1.5);
    REQUIRE(waves.highest_hz() > 150);
    // Of the mode (1, 0, 0): c / (2 * 5 m).
    const MapCells cells = waves.cells(source, 34.3);
    CHECK(cells.height_m() == 1.5F);
    const auto level_db = [&](float x) {
        const MapCells::Cell* const cell = cells.at({x, 2});
        REQUIRE(cell != nullptr);
        return cell->value.value();
    };
    CHECK(level_db(0.2F) == Approx(level_db(4.8F)).margin(1.5));
    CHECK(level_db(0.2F) - level_db(2.5F) > 15);
    CHECK(cells.at({-0.5F, 2}) == nullptr);
    CHECK(cells.at({2.5F, 4.6F}) == nullptr);
    const auto [quietest, loudest] =
        std::minmax_element(cells.cells().begin(), cells.cells().end(),
                            [](const auto& a, const auto& b) { return *a.value < *b.value; });
    CHECK(cells.scale().max == Approx(*loudest->value));
    CHECK(*quietest->value < cells.scale().max - 15);
    CHECK(waves.cells({-3, 0, 0}, 63).cells().empty());
}

TEST_CASE("In the open there are no standing waves, and a line says why") {
    Scene scene = test::grey_room(test::square(5), 0.1F, 0.1F, {0, 0, 1}, {1, 0, 1});
    scene.simulation = {};
    Bounds bounds;
    bounds.min = Vec3(-5, -5, 0);
    bounds.max = Vec3(5, 5, 2);
    const StandingWaves waves(scene, bounds, 1);
    CHECK(waves.highest_hz() == 0);
    CHECK(waves.cells({0, 0, 1}, 63).cells().empty());
    CHECK(waves.warnings().size() == 1);
}

}  // namespace standing_waves_test
