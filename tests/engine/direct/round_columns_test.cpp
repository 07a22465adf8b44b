// Walks behind round columns, which are prisms of many sides.

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "engine/direct/direct_sound.h"
#include "tests/engine/direct/frame_levels.h"
#include "tests/engine/edges/obstacles.h"

using aula::DirectSound;
using aula::Object;
using aula::PairMemory;
using aula::Vec3;
using aula::test::frame_levels_db;
using aula::test::Place;
using aula::test::prism;

namespace {

constexpr std::size_t kOctaves = 5;  // up to 1 kHz; above it interference varies with the place
using Levels = std::array<double, aula::kBandCount>;

Object column(int sides, float turn_rad) {
    std::vector<std::array<float, 2>> base;
    for (int i = 0; i < sides; ++i) {
        const float angle_rad = turn_rad + 2 * std::numbers::pi_v<float> * static_cast<float>(i) /
                                               static_cast<float>(sides);
        base.push_back({0.3F * std::cos(angle_rad), 0.3F * std::sin(angle_rad)});
    }
    return prism(base);
}

}  // namespace

TEST_CASE("on a walk behind a column of any number of sides no octave jumps") {
    // Bounds per centimetre, for steps of 4 mm. In the shadow, at its boundary and beside it the
    // path touches one edge, two of a side, or more.
    constexpr std::array<double, kOctaves> kStep_db{0.2, 0.2, 0.2, 0.3, 0.4};
    constexpr double kStep_cm = 0.4;
    const Vec3 source(-3, 0, 0);
    for (const auto& [sides, turn_rad] :
         {std::pair(8, 0.0F), {12, 0.1F}, {20, 0.0F}, {24, 0.0F}, {24, 0.05F}, {32, 0.0F}}) {
        const Place place({column(sides, turn_rad)});
        DirectSound walked(place.rays, 343.2F, 2);
        PairMemory memory;
        double largest_at_rest = 0;
        double largest_walked = 0;
        Levels last_at_rest{};
        Levels last_walked{};
        for (int i = -200; i <= 200; ++i) {
            const Vec3 listener(2, 0.004F * static_cast<float>(i), 0);
            DirectSound fresh(place.rays, 343.2F, 2);
            PairMemory none;
            const Levels at_rest = frame_levels_db(fresh, none, source, listener);
            const Levels now = frame_levels_db(walked, memory, source, listener);
            for (std::size_t b = 0; b < kOctaves && i > -200; ++b) {
                const double bound_db = kStep_db[b] * kStep_cm;
                largest_at_rest =
                    std::max(largest_at_rest, std::abs(at_rest[b] - last_at_rest[b]) / bound_db);
                largest_walked =
                    std::max(largest_walked, std::abs(now[b] - last_walked[b]) / bound_db);
            }
            last_at_rest = at_rest;
            last_walked = now;
        }
        CAPTURE(sides, turn_rad);
        CHECK(largest_at_rest < 1);
        CHECK(largest_walked < 1);
    }
}
