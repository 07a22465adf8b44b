// Limits of rows of edges: where their shares fade, and which paths they cover.

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "engine/direct/edge_row.h"
#include "engine/direct/limits.h"
#include "tests/engine/direct/edge_rows.h"
#include "tests/engine/edges/obstacles.h"

using aula::Bands;
using aula::ComplexBands;
using aula::EdgeRow;
using aula::kBandCount;
using aula::Object;
using aula::Vec3;
using aula::WedgeIntegral;
using aula::test::kFar_m;
using aula::test::Place;
using aula::test::prism;
using aula::test::row_over;
using aula::test::screen;

TEST_CASE("a row covers the straight path where it touches the tops, not where they hide it") {
    const Place place({screen(0, 0), screen(3, 0)});
    const auto covered = [&](float below_m) {
        const auto over = row_over(place, {{0, 0}, {3, 0}}, {-3, -below_m, 0}, {6, -below_m, 0});
        REQUIRE(over);
        CHECK(over->weight() == 1);
        return over->covered({});
    };
    CHECK(covered(-0.02F) == 1);
    CHECK(covered(0) == 1);
    CHECK(covered(0.009F) == 1);
    CHECK(covered(0.03F) == Approx(0.5).margin(1e-4));
    CHECK(covered(0.051F) == 0);
    CHECK(covered(0.5F) == 0);
}

TEST_CASE("edges form a row if they are nearly parallel and on one side of the path") {
    const auto has_row = [](const Object& second) {
        const Place place({screen(0, 0), second});
        std::vector<std::uint32_t> edges;
        for (std::uint32_t e = 0; e < place.edges.count(); ++e) {
            const bool is_across = std::abs(place.edges[e].axis.z) > 0.5;
            if (is_across && std::abs(place.edges[e].start.y) < 1e-3) edges.push_back(e);
        }
        REQUIRE(edges.size() == 2);
        return EdgeRow::over(place.edges, edges, {-3, 0, 0}, {6, 0, 0}).has_value();
    };
    const auto turned = [](float angle_rad) {
        Object object = screen(3, 0);
        for (Vec3& vertex : object.vertices) {
            vertex.z = std::clamp(vertex.z, -1.5F, 1.5F);
            vertex.x += std::tan(angle_rad) * vertex.z;
        }
        return object;
    };
    Object hanging = screen(3, 0);
    for (Vec3& vertex : hanging.vertices) vertex.y = -vertex.y;
    CHECK(has_row(screen(3, 0)));
    CHECK(has_row(turned(0.12F)));
    CHECK_FALSE(has_row(turned(0.16F)));
    CHECK_FALSE(has_row(hanging));
}

TEST_CASE("the higher one of two bends tells whether a row hides the straight path") {
    // The bends are 0.05 and 0.03 m above it, in either order.
    for (const bool is_first_higher : {true, false}) {
        const float low_m = -0.02F;
        const float first_m = is_first_higher ? 0 : low_m;
        const float last_m = is_first_higher ? low_m : 0;
        const Place place({screen(0, first_m), screen(3, last_m)});
        const auto over =
            row_over(place, {{0, first_m}, {3, last_m}}, {-3, -0.05F, 0}, {6, -0.05F, 0});
        REQUIRE(over);
        CHECK(over->covered({}) == Approx(0).margin(1e-4));
    }
}

TEST_CASE("a row fades out over the last quarter of the longest detour") {
    const auto weight = [](double detour_m) {
        // Half of the detour on each side, 200 m before and behind the screens.
        const double side_m = 200 + detour_m / 2;
        const auto below_m = static_cast<float>(std::sqrt(side_m * side_m - 200 * 200));
        const Place place({screen(0, 0), screen(3, 0)});
        const auto over =
            row_over(place, {{0, 0}, {3, 0}}, {-200, -below_m, 0}, {203, -below_m, 0});
        return over ? over->weight() : 0;
    };
    const double longest_m = aula::limits::kLongestDetour_m;
    CHECK(weight(0.7 * longest_m) == 1);
    CHECK(weight(0.875 * longest_m) == Approx(0.5).margin(1e-3));
    CHECK(weight(1.001 * longest_m) == 0);
}

TEST_CASE("the search keeps rows that both ends may come to before the next search") {
    // Each end may move by 0.15 m: together they shorten the detour by up to 0.3 m.
    const Place place({screen(0, 0), screen(3, 0)});
    std::vector<std::uint32_t> tops;
    for (const double x : {0.0, 3.0}) {
        tops.push_back(static_cast<std::uint32_t>(place.edge_at(x, 0) - place.edges.all().data()));
    }
    const auto rows = [&](double beyond_m) {
        // The detour over the screen that is nearer to the middle.
        const double side_m = 201.5 + (aula::limits::kLongestDetour_m + beyond_m) / 2;
        const double below_m = std::sqrt(side_m * side_m - 201.5 * 201.5);
        return EdgeRow::candidates(place.edges, tops, {-200, -below_m, 0}, {203, -below_m, 0});
    };
    CHECK(rows(0.1).size() == 1);
    CHECK(rows(0.5).empty());
}

TEST_CASE("a row covers the paths over its edges, and no other") {
    const Place place({screen(0, 0), screen(3, 0), screen(20, 0)});
    const auto over = row_over(place, {{0, 0}, {3, 0}}, {-3, 0, 0}, {6, 0, 0});
    REQUIRE(over);
    const auto index = [&](double x) {
        return static_cast<std::uint32_t>(place.edge_at(x, 0) - place.edges.all().data());
    };
    CHECK(over->covered(std::array{index(0)}) == 1);
    CHECK(over->covered(std::array{index(0), index(3)}) == 1);
    CHECK(over->covered(std::array{index(0), index(20)}) == 0);
}

TEST_CASE("an edge of a row fades out towards its end") {
    // The path touches two screens and passes a third one, 0.3 m below it and 3 m before the
    // listener, whose end is `inside_m` beside the path.
    constexpr float kBelow_m = 0.3F;
    const WedgeIntegral integral(343.2);
    const auto field_of_third = [&](float inside_m) {
        Object last = screen(6, -kBelow_m);
        for (Vec3& vertex : last.vertices) vertex.z = std::min(vertex.z, inside_m);
        const Place place({screen(0, 0), screen(3, 0), last});
        const auto with = row_over(place, {{0, 0}, {3, 0}, {6, -kBelow_m}}, {-3, 0, 0}, {9, 0, 0});
        const auto without = row_over(place, {{0, 0}, {3, 0}}, {-3, 0, 0}, {9, 0, 0});
        REQUIRE((with && without));
        ComplexBands field = with->path(integral, place.rays, place.edges, Bands{}).field;
        const ComplexBands rest = without->path(integral, place.rays, place.edges, Bands{}).field;
        for (std::size_t b = 0; b < kBandCount; ++b) field[b] = field[b] / rest[b] - 1.0;
        return field;
    };
    const ComplexBands beyond = field_of_third(0.31F);  // the share falls from 0.3 m on
    const ComplexBands at_end = field_of_third(0.03F);
    // Its share of 0.028 lowers the edge to 1.8 m. Over 9 m before it and 3 m after it the field of
    // a half plane alone is then 1 / (2 sqrt(pi detour)); where its detour is below 20 rad, the
    // screens in front of it take most of that.
    constexpr double kDetour_m = 0.5 * 0.3 * 0.3 / 0.028 * (1 / 9.0 + 1 / 3.0);
    for (std::size_t b = 2; b < kBandCount; ++b) {
        const double detour_rad = integral.wave_number_per_m(b) * kDetour_m;
        const double alone = 1 / (2 * std::sqrt(std::numbers::pi * detour_rad));
        CAPTURE(b, alone);
        if (detour_rad > 20) {
            CHECK(std::abs(at_end[b]) == Approx(alone).epsilon(0.002));
        } else {
            CHECK(std::abs(at_end[b]) < alone);
        }
        CHECK(std::abs(at_end[b]) < std::abs(beyond[b]));
    }
}
