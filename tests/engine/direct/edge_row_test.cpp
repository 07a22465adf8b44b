#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <glm/geometric.hpp>
#include <numbers>
#include <vector>

#include "aula/engine/scene_file.h"
#include "engine/base/sampling.h"
#include "engine/direct/direct_sound.h"
#include "engine/direct/edge_row.h"
#include "tests/engine/direct/edge_rows.h"
#include "tests/engine/direct/frame_levels.h"
#include "tests/engine/edges/obstacles.h"

namespace edge_row_test {

using aula::Bands;
using aula::ComplexBands;
using aula::DirectSound;
using aula::EdgePath;
using aula::EdgeRow;
using aula::kBandCount;
using aula::Object;
using aula::PairMemory;
using aula::RandomStream;
using aula::Vec3;
using aula::WedgeIntegral;
using aula::test::bar;
using aula::test::kFar_m;
using aula::test::Place;
using aula::test::prism;
using aula::test::row_over;
using aula::test::screen;
using Levels = std::array<double, kBandCount>;

namespace {

Object thick_screen(float x, float top_m) {
    constexpr float kWidth_m = 0.1F;
    return prism({{x, -kFar_m}, {x + kWidth_m, -kFar_m}, {x + kWidth_m, top_m}, {x, top_m}});
}

std::vector<Object> row(int count, float distance_m, float top_m) {
    std::vector<Object> screens;
    for (int i = 0; i < count; ++i)
        screens.push_back(screen(distance_m * static_cast<float>(i), top_m));
    return screens;
}

/// Levels of the first frame.
Levels levels_db(DirectSound& direct_sound, const Vec3& source, const Vec3& listener) {
    PairMemory memory;
    return aula::test::frame_levels_db(direct_sound, memory, source, listener);
}

Levels levels_db(const Place& place, int order, const Vec3& source, const Vec3& listener) {
    DirectSound direct_sound(place.rays, 343.2F, order);
    return levels_db(direct_sound, source, listener);
}

double largest_difference_db(const Levels& a, const Levels& b) {
    double largest = 0;
    for (std::size_t i = 0; i < kBandCount; ++i) largest = std::max(largest, std::abs(a[i] - b[i]));
    return largest;
}

constexpr double kOrders_db = 1;

/// An octagonal column of a church, 0.72 m from side to side.
Object octagon(float x, float y) {
    constexpr float kToSide_m = 0.36F;
    const float half_side_m = kToSide_m * std::tan(std::numbers::pi_v<float> / 8);
    std::vector<std::array<float, 2>> base;
    for (int i = 0; i < 8; ++i) {
        const float angle_rad = (static_cast<float>(i) - 0.5F) * std::numbers::pi_v<float> / 4;
        const float radius_m = std::hypot(kToSide_m, half_side_m);
        base.push_back({x + radius_m * std::cos(angle_rad), y + radius_m * std::sin(angle_rad)});
    }
    return prism(base);
}

/// Levels at the centres of octaves by boundary elements, a point source beside endless columns.
struct ColumnCase {
    Vec3 source;
    Vec3 listener;
    std::vector<double> level_db;
};

const std::vector<ColumnCase> kOneColumn{
    {{-3, 0, 0}, {2, 0, 0}, {0.0, -0.4, -1.1, -2.2, -3.6, -5.7}},
    {{-3, 0, 0}, {2, 0.6F, 0}, {-0.1, -0.7, -2.5, -7.1, -4.1, -6.6}},
    {{-3, 0, 0}, {2, 1.5F, 0}, {-0.3, -1.5, -2.1, 1.5, 1.3, -1.5}},
    {{-3, 1, 0}, {1, -0.2F, 0}, {-0.3, -0.7, -1.8, -4.0, -9.4, -15.7}},
};

// Five columns at x = 4, 8, .. 20 m, y = 4.6 m. The third listener sees the source.
const std::vector<ColumnCase> kRowOfColumns{
    {{26.8F, -1, 0}, {2, 5, 0}, {-0.1, -2.0, -3.5, -4.4}},
    {{26.8F, -1, 0}, {1, 7, 0}, {0.0, -1.2, -3.8, -1.1}},
    {{26.8F, -1, 0}, {5, 5, 0}, {1.6, -2.5, -2.3, -5.8}},
    {{26.8F, -1, 0}, {16.2F, 7, 0}, {0.4, 0.9, -2.7, -4.8}},
    {{26.8F, -1, 0}, {17.4F, 6.4F, 0}, {0.4, -0.1, -0.6, -1.6}},
    {{26.8F, -1, 0}, {18, 5.8F, 0}, {-0.2, -0.2, 0.4, -2.6}},
    {{26.8F, -1, 0}, {10, 5.4F, 0}, {-0.6, 2.0, -0.5, -6.6}},
};

/// The church, of one rigid material.
Place church_place(Vec3& source) {
    aula::Scene church = aula::load_scene(AULA_SOURCE_DIR "/scenes/church.json").scene;
    for (Object& object : church.objects) {
        std::fill(object.triangle_materials.begin(), object.triangle_materials.end(), 0);
    }
    source = church.sources.front().position;
    return Place(church.objects);
}

}  // namespace

TEST_CASE("edges within an obstacle are no obstacles of their own") {
    struct Hidden {
        std::vector<Object> with;     ///< edges within an obstacle, or below one of its faces
        std::vector<Object> without;  ///< the same place without these edges
        Vec3 source;
        Vec3 listener;
    };
    const auto rest = [](float x0, float x1, float top_m) {
        return prism({{x0, -kFar_m}, {x1, -kFar_m}, {x1, top_m}, {x0, top_m}});
    };
    // The sill of a fanlight in a wall of 0.2 m. A leaf that moves has its edges also where it is
    // shut, below the sill.
    const Object sill = prism({{0, -0.1F}, {0.2F, -0.1F}, {0.2F, 0}, {0, 0}});
    Object shut_leaf = rest(0.08F, 0.12F, -0.1F);
    shut_leaf.movable = true;
    // A leaf that is open at right angles, and the corner of the jamb behind its face.
    const Object open_leaf = prism({{0.1F, -0.02F}, {1, -0.02F}, {1, 0.02F}, {0.1F, 0.02F}});
    const std::array cases{Hidden{{sill, shut_leaf},
                                  {sill, rest(0.08F, 0.12F, -0.1F)},
                                  {-2.8F, -1.05F, 0},
                                  {2.2F, -0.5F, 0}},
                           Hidden{{open_leaf, rest(0, 0.2F, 0)},
                                  {open_leaf, rest(0, 0.1F, 0)},
                                  {-2.8F, 1.6F, 0},
                                  {2.8F, -0.7F, 0}}};
    for (const Hidden& c : cases) {
        const Levels with = levels_db(Place(c.with), 2, c.source, c.listener);
        const Levels without = levels_db(Place(c.without), 2, c.source, c.listener);
        CAPTURE(with, without);
        CHECK(largest_difference_db(with, without) < 0.1);
    }
}

TEST_CASE("a straight path that touches the tops of N screens has the level of 1 / (N + 1)") {
    for (const int count : {2, 3, 4, 8, 12}) {
        const Place place(row(count, 3, 0));
        const Vec3 source(-3, 0, 0);
        const Vec3 listener(3.0F * static_cast<float>(count), 0, 0);
        for (int order = 1; order <= 4; ++order) {
            CAPTURE(count, order);
            for (const double level_db : levels_db(place, order, source, listener))
                CHECK(level_db == Approx(-20 * std::log10(count + 1)).margin(0.05));
        }
        // Single paths add up to nothing of the kind: half of free field for each screen.
        double sum = 0;
        for (const EdgePath& path : place.single_paths(source, listener))
            sum += path.field[3].real();
        const double distance_m = 3.0 * (count + 1);
        CHECK(std::abs(20 * std::log10(std::abs(sum) * distance_m + 1e-3) +
                       20 * std::log10(count + 1)) > 4);
    }
}

TEST_CASE("behind a row of screens the level does not depend on the order of diffraction") {
    for (const int count : {2, 3, 4, 5, 12, 30}) {
        const Place place(row(count, 1, 2.5F));
        const Vec3 source(-2, 1, 0);
        const Vec3 listener(static_cast<float>(count) + 1, 1, 0);
        const Levels first = levels_db(place, 1, source, listener);
        for (int order = 2; order <= 4; ++order) {
            CAPTURE(count, order);
            CHECK(largest_difference_db(first, levels_db(place, order, source, listener)) <
                  kOrders_db);
        }
        // Never silent: two sharp bends of 45 degrees have -20 dB each at 1 kHz.
        CHECK(first[4] > -80);
    }
}

TEST_CASE("more screens are never louder") {
    Levels last = levels_db(Place(row(2, 1, 2.5F)), 2, {-2, 1, 0}, {3, 1, 0});
    for (int count = 3; count <= 12; ++count) {
        const Levels levels = levels_db(Place(row(count, 1, 2.5F)), 2, {-2, 1, 0},
                                        {static_cast<float>(count) + 1, 1, 0});
        for (std::size_t b = 0; b < kBandCount; ++b) CHECK(levels[b] < last[b]);
        last = levels;
    }
}

TEST_CASE("the level is continuous in the height of a screen in a row") {
    // 1 mm of height is less than 1/40 of a wavelength at 8 kHz.
    constexpr double kStep_db = 0.2;
    for (const int order : {1, 2, 3}) {
        Levels last{};
        for (int i = -40; i <= 40; ++i) {
            auto screens = row(3, 1, 2.5F);
            screens[1] = screen(1, 2.5F + 1e-3F * static_cast<float>(i));
            const Levels levels = levels_db(Place(screens), order, {-2, 1, 0}, {4, 1, 0});
            CAPTURE(order, i);
            if (i > -40) CHECK(largest_difference_db(levels, last) < kStep_db);
            last = levels;
        }
    }
    // Screens of nearly equal heights.
    for (const float height_m : {2.4999F, 2.5F, 2.5001F}) {
        auto screens = row(3, 1, 2.5F);
        screens[1] = screen(1, height_m);
        CHECK(levels_db(Place(screens), 2, {-2, 1, 0}, {4, 1, 0})[4] > -40);
    }
}

TEST_CASE("over rows of thin and thick screens both ends hear the same") {
    RandomStream random(3);
    for (int trial = 0; trial < 40; ++trial) {
        const int count = 2 + trial % 7;
        const bool is_even = trial % 3 == 0;
        std::vector<Object> screens;
        for (int i = 0; i < count; ++i) {
            const float top_m = 1.2F + (is_even ? 0 : 0.3F * random.uniform());
            const float x = 1.2F * static_cast<float>(i);
            screens.push_back(trial % 2 == 0 ? screen(x, top_m) : thick_screen(x, top_m));
        }
        const Place place(screens);
        const Vec3 source(-1.5F, 0.8F + 0.7F * random.uniform(), 0);
        const Vec3 listener(1.2F * static_cast<float>(count) + 1, 0.8F + 0.7F * random.uniform(),
                            0.5F);
        const Levels there = levels_db(place, 2, source, listener);
        const Levels back = levels_db(place, 2, listener, source);
        CAPTURE(trial);
        CHECK(largest_difference_db(there, back) < 0.2);
        CHECK(*std::min_element(there.begin(), there.end()) > -100);
        for (const int order : {1, 4})
            CHECK(largest_difference_db(there, levels_db(place, order, source, listener)) <
                  kOrders_db);
    }
}

TEST_CASE("over the pews of a church the direct sound of a lit listener is not above free field") {
    // The straight path passes 11 pews half a metre above their tops, next to the end of an arch,
    // and the columns of an aisle.
    Vec3 source;
    const Place place = church_place(source);
    const Vec3 listener{0.6F, 6, 1.2F};
    REQUIRE(place.rays.visible(listener, source));
    Vec3 beside = listener;
    beside.x = std::nextafter(beside.x, 1.0F);
    for (const int order : {1, 2}) {
        const Levels levels = levels_db(place, order, source, listener);
        CAPTURE(order, levels);
        // At grazing incidence the pews take some of the level, at most that of 11 knife edges.
        CHECK(*std::max_element(levels.begin(), levels.end()) < 6);
        CHECK(*std::min_element(levels.begin(), levels.end()) > -15);
        CHECK(largest_difference_db(levels, levels_db(place, order, source, beside)) < 1);
    }
}

TEST_CASE("an oblique path over a row is that across it over screens farther apart") {
    // Seen along the path the screens are farther apart by its length per length across the edges,
    // and its bends are as many times smaller. Below 2 kHz the faces beside a sharper bend have
    // more of the level.
    constexpr float kStretch = 2;
    constexpr std::size_t kFirstBand = 5;
    constexpr double kFaces_db = 0.2;
    const float beside_m = 9 * std::sqrt(kStretch * kStretch - 1);
    const WedgeIntegral integral(343.2);
    const Place near({screen(0, 0), screen(3, 0)});
    const Place far({screen(0, 0), screen(3 * kStretch, 0)});
    for (const float below_m : {0.0F, 0.05F, 0.1F, 0.15F}) {
        const auto oblique =
            row_over(near, {{0, 0}, {3, 0}}, {-3, -below_m, 0}, {6, -below_m, beside_m});
        const auto across = row_over(far, {{0, 0}, {3 * kStretch, 0}}, {-3 * kStretch, -below_m, 0},
                                     {6 * kStretch, -below_m, 0});
        REQUIRE((oblique && across));
        const EdgePath a = oblique->path(integral, near.rays, near.edges, Bands{});
        const EdgePath b = across->path(integral, far.rays, far.edges, Bands{});
        // Unfolded, both paths bend by as much; the path across bends at right angles to its edges.
        CHECK(a.length_m == Approx(b.length_m).margin(1e-5));
        for (std::size_t band = kFirstBand; band < kBandCount; ++band) {
            CAPTURE(below_m, band);
            CHECK(20 * std::log10(std::abs(a.field[band]) / std::abs(b.field[band])) ==
                  Approx(0).margin(kFaces_db));
        }
    }
}

TEST_CASE("behind octagonal columns the level is that of boundary elements") {
    const Place one({octagon(0, 0)});
    for (const ColumnCase& c : kOneColumn) {
        const Levels levels = levels_db(one, 2, c.source, c.listener);
        for (std::size_t b = 0; b < c.level_db.size(); ++b) {
            CAPTURE(c.listener.x, c.listener.y, b);
            CHECK(levels[b] == Approx(c.level_db[b]).margin(2.3));
        }
    }
    std::vector<Object> columns;
    for (const float x : {4.F, 8.F, 12.F, 16.F, 20.F}) columns.push_back(octagon(x, 4.6F));
    const Place row_of_columns(columns);
    double square = 0;
    double square_wall = 0;
    double count = 0;
    const Place wall({bar(10, 0.36F)});
    for (const ColumnCase& c : kRowOfColumns) {
        const Levels levels = levels_db(row_of_columns, 2, c.source, c.listener);
        // Companion: a wall from the first column to the last one.
        const Vec3 from_middle{12, 4.6F, 0};
        const Levels behind_wall =
            levels_db(wall, 2, c.source - from_middle, c.listener - from_middle);
        for (std::size_t b = 0; b < c.level_db.size(); ++b) {
            CAPTURE(c.listener.x, c.listener.y, b);
            CHECK(levels[b] == Approx(c.level_db[b]).margin(6));
            square += std::pow(levels[b] - c.level_db[b], 2);
            square_wall += std::pow(behind_wall[b] - c.level_db[b], 2);
            ++count;
        }
    }
    CHECK(std::sqrt(square / count) < 2.4);
    CHECK(std::sqrt(square_wall / count) > 5);
}

TEST_CASE("over twenty pews the level is that of boundary elements") {
    // Backs of 0.1 m thickness, 1 m apart, whose tops are at 0.95 m. At 63 Hz sound also passes
    // their lower ends at -4 m.
    std::vector<Object> pews;
    for (int i = 0; i < 20; ++i) {
        const float x = 4.5F + static_cast<float>(i);
        pews.push_back(prism({{x, -4}, {x + 0.1F, -4}, {x + 0.1F, 0.95F}, {x, 0.95F}}));
    }
    const Place place(pews);
    const Vec3 source{26.8F, 1.6F, 0};
    struct Case {
        Vec3 listener;
        std::array<double, 2> level_db;  // 63 and 125 Hz
    };
    for (const Case& c : {Case{{2, 1.2F, 0}, {-19.1, -17.1}}, Case{{0.6F, 1.2F, 0}, {-18.9, -16.4}},
                          Case{{2, 0.9F, 0}, {-21.1, -18.8}}, Case{{2, 1.65F, 0}, {-16.2, -14.7}},
                          Case{{3.5F, 1.2F, 0}, {-18.0, -18.5}}}) {
        const Levels levels = levels_db(place, 2, source, c.listener);
        CAPTURE(c.listener.x, c.listener.y);
        CHECK(levels[0] == Approx(c.level_db[0]).margin(1.8));
        CHECK(levels[1] == Approx(c.level_db[1]).margin(0.6));
        // Companion: the sum over single edges.
        std::complex<double> single;
        for (const EdgePath& path : place.single_paths(source, c.listener)) single += path.field[1];
        const double distance_m = double{glm::distance(source, c.listener)};
        CHECK(std::abs(20 * std::log10(std::abs(single) * distance_m) - c.level_db[1]) > 6);
    }
}

TEST_CASE("in a church no place is louder than free field and the strongest edge allow") {
    Vec3 source;
    const Place place = church_place(source);
    DirectSound direct_sound(place.rays, 343.2F, 2);
    double loudest_db = -100;
    double loudest_single_db = -100;
    int unlit = 0;
    std::vector<Vec3> listeners{{2, 5, 1.65F}, {1, 7, 1.65F}, {4.2F, -0.8F, 1.2F}};
    for (int x = 0; x < 7; ++x) {
        for (const float y : {-6.2F, -5.F, 5.2F, 6.4F}) {
            listeners.emplace_back(0.6F + 1.8F * static_cast<float>(x), y, 1.2F);
        }
    }
    for (const Vec3& listener : listeners) {
        const bool is_lit = place.rays.visible(listener, source);
        const Levels levels = levels_db(direct_sound, source, listener);
        const double limit_db = is_lit ? 4.5 : 2.5;
        ComplexBands sum{};
        double strongest = 1;
        for (const EdgePath& path : place.single_paths(source, listener)) {
            const double distance_m = double{glm::distance(source, listener)};
            for (std::size_t b = 0; b < kBandCount; ++b) {
                sum[b] += path.field[b] * distance_m;
                if (!path.edges.empty())
                    strongest = std::max(strongest, std::abs(path.field[b]) * distance_m);
            }
        }
        CAPTURE(listener.x, listener.y, is_lit);
        const double level_db = *std::max_element(levels.begin(), levels.end());
        CHECK(level_db < limit_db + 20 * std::log10(strongest) + 0.01);
        if (is_lit) continue;
        ++unlit;
        loudest_db = std::max(loudest_db, levels[0]);
        loudest_single_db = std::max(loudest_single_db, 20 * std::log10(std::abs(sum[0])));
    }
    CHECK(unlit > 10);
    CHECK(loudest_db < 2.51);
    CHECK(loudest_single_db > 4);  // companion
}

}  // namespace edge_row_test
