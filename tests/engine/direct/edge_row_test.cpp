#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <vector>

#include "aula/engine/scene_file.h"
#include "engine/base/sampling.h"
#include "engine/direct/direct_sound.h"
#include "tests/engine/edges/obstacles.h"

using aula::Bands;
using aula::DirectSound;
using aula::EdgePath;
using aula::kBandCount;
using aula::Object;
using aula::PairMemory;
using aula::RandomStream;
using aula::SpecularPath;
using aula::Vec3;
using aula::test::kFar_m;
using aula::test::Place;
using aula::test::prism;
using Levels = std::array<double, kBandCount>;

namespace {

/// A thin wall across x from far below to y = `top_m`.
Object screen(float x, float top_m) {
    Object object;
    object.vertices = {
        {x, -kFar_m, -kFar_m}, {x, top_m, -kFar_m}, {x, top_m, kFar_m}, {x, -kFar_m, kFar_m}};
    object.triangles = {{0, 1, 2}, {0, 2, 3}};
    object.triangle_materials = {0, 0};
    return object;
}

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

/// Levels of the direct sound relative to free field.
Levels levels_db(const Place& place, int order, const Vec3& source, const Vec3& listener) {
    DirectSound direct_sound(place.rays, 343.2F, order);
    PairMemory memory;
    direct_sound.begin_frame(false);
    direct_sound.search({&source, 1}, {&listener, 1}, {&memory, 1});
    Bands sum;
    for (const SpecularPath& path : direct_sound.find(source, listener, {}, Bands{}, memory)) {
        sum += path.energy;
    }
    const double distance_m = double{glm::distance(source, listener)};
    Levels levels;
    for (std::size_t b = 0; b < kBandCount; ++b) {
        levels[b] =
            10 *
            std::log10(4 * std::numbers::pi * distance_m * distance_m * double{sum[b]} + 1e-20);
    }
    return levels;
}

double largest_difference_db(const Levels& a, const Levels& b) {
    double largest = 0;
    for (std::size_t i = 0; i < kBandCount; ++i) largest = std::max(largest, std::abs(a[i] - b[i]));
    return largest;
}

constexpr double kOrders_db = 1;

}  // namespace

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
    aula::Scene church = aula::load_scene(AULA_SOURCE_DIR "/scenes/church.json").scene;
    for (Object& object : church.objects) {
        std::fill(object.triangle_materials.begin(), object.triangle_materials.end(), 0);
    }
    const Place place(church.objects);
    const Vec3 source = church.sources.front().position;
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
