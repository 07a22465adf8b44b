#include "engine/patches/cell_clipping.h"

#include <algorithm>
#include <catch2/catch.hpp>

#include "engine/base/sampling.h"

using namespace aula;

TEST_CASE(
    "random points in a polygon are uniform: each part has a number in proportion to its area") {
    // A triangle without one corner, and a triangle.
    ClippedPolygon polygon;
    for (const Vec3& v : {Vec3(0, 0, 1), Vec3(3, 0, 1), Vec3(0, 2, 1)}) polygon.add(v);
    for (const ClippedPolygon& whole : {polygon, polygon.cut(0, 2, 1), polygon.cut(1, 0.5F, -1)}) {
        for (const auto& [axis, at_m] : {std::pair{0, 0.5F}, {0, 1.5F}, {1, 0.4F}, {1, 1.2F}}) {
            constexpr int kSteps = 200;
            int below = 0;
            for (int i = 0; i < kSteps; ++i) {
                for (int k = 0; k < kSteps; ++k) {
                    const Vec3 point = whole.point({(static_cast<float>(i) + 0.5F) / kSteps,
                                                    (static_cast<float>(k) + 0.5F) / kSteps});
                    below += point[axis] < at_m ? 1 : 0;
                }
            }
            const ClippedPolygon part = whole.cut(axis, at_m, 1);
            const double share =
                part.count() > 2 ? double{part.area_m2()} / double{whole.area_m2()} : 0;
            CAPTURE(whole.count(), axis, at_m);
            // The grid's cells at the border: a few of 200 rows' ends.
            CHECK(below / double{kSteps * kSteps} == Approx(share).margin(2.0 / kSteps));
        }
    }
}

TEST_CASE("a triangle is divided among the cells: each part lies in its cell, none is lost") {
    const GridAxis axis(4, 1, {});
    const Cuts cuts{axis, axis, axis};
    RandomStream random(1);
    for (int trial = 0; trial < 200; ++trial) {
        ClippedPolygon triangle;
        for (int k = 0; k < 3; ++k) {
            // Some beyond the ends of the axes.
            const auto xy = random.uniform_2d();
            triangle.add(6.0F * Vec3(xy[0], xy[1], random.uniform()) - 1.0F);
        }
        double sum_m2 = 0;
        float outside_m = 0;
        for_each_cell(triangle, cuts, 0, {},
                      [&](const CellIndex& cell, const ClippedPolygon& part) {
                          sum_m2 += double{part.area_m2()};
                          for (int i = 0; i < part.count(); ++i) {
                              for (int a = 0; a < 3; ++a) {
                                  const std::int32_t k = cell[static_cast<std::size_t>(a)];
                                  outside_m = std::max({outside_m, axis.begin_m(k) - part.at(i)[a],
                                                        part.at(i)[a] - axis.begin_m(k + 1)});
                              }
                          }
                      });
        // Rounding of coordinates up to 5.
        CHECK(sum_m2 == Approx(double{triangle.area_m2()}).epsilon(1e-4).margin(1e-5));
        CHECK(outside_m < 1e-5F);
    }
}
