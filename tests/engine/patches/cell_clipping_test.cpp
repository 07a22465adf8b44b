#include "engine/patches/cell_clipping.h"

#include <catch2/catch.hpp>

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
