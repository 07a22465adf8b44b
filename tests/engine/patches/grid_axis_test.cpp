#include "engine/patches/grid_axis.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <vector>

using aula::GridAxis;

namespace {

int cells_between(const GridAxis& cuts, float from_m, float to_m) {
    return cuts.cell(to_m) - cuts.cell(from_m);
}

}  // namespace

TEST_CASE("a position lies in the cell that contains it") {
    for (const float cell_m : {0.1F, 0.5F, 3.0F}) {
        const GridAxis cuts(10.13F, cell_m, {{2.31F, 10}, {2.44F, 9}, {7.77F, 1}});
        for (float x = -3; x < 14; x += 0.00371F) {
            const std::int32_t k = cuts.cell(x);
            CAPTURE(cell_m, x, k);
            // Beyond the ends borders are products and quotients of floats.
            const float rounding = x < 0 || x > 10.13F ? 2e-6F : 0;
            CHECK(cuts.begin_m(k) <= x + rounding);
            CHECK(x < cuts.begin_m(k + 1) + rounding);
            CHECK(cuts.begin_m(k + 1) - cuts.begin_m(k) < cell_m * 1.002F);
        }
        for (std::int32_t k = 0; k < cuts.cell(10.13F); ++k) CHECK(cuts.cell(cuts.begin_m(k)) == k);
    }
}

TEST_CASE("cells are cut at walls, at small ones only if they are apart from larger ones") {
    const GridAxis cuts(10, 0.5F, {{2.3F, 10}, {2.31F, 20}, {5.05F, 5}});
    CHECK(cells_between(cuts, 2.3099F, 2.3101F) == 1);
    CHECK(cells_between(cuts, 2.2999F, 2.3001F) == 0);
    CHECK(cells_between(cuts, 5.0499F, 5.0501F) == 1);
    const GridAxis none(10, 0.5F, {});
    CHECK(cells_between(none, 2.3099F, 2.3101F) == 0);  // companion
    CHECK(cells_between(none, 0, 10) == 20);
}

TEST_CASE("many walls at most double the number of cells, and a flat scene separates its sides") {
    std::vector<GridAxis::Wall> walls;
    for (int i = 1; i < 1000; ++i) walls.push_back({0.01F * static_cast<float>(i), 1.0});
    const GridAxis cuts(10, 0.5F, walls);
    CHECK(cuts.cell(9.999F) <= 2 * 20);
    const GridAxis flat(0, 0.5F, {});
    CHECK(flat.cell(1e-4F) == flat.cell(0));
    CHECK(flat.cell(-1e-4F) != flat.cell(0));
}

TEST_CASE("a position that is not finite has a valid cell") {
    const GridAxis cuts(10, 0.5F, {});
    for (const float none : {std::numeric_limits<float>::quiet_NaN(), 1e30F, -1e30F,
                             std::numeric_limits<float>::infinity()}) {
        CHECK(cuts.cell(none) == 0);
    }
    CHECK(cuts.cell(1e3F) > 20);  // companion: far away, but finite
}
