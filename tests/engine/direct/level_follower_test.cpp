#include "engine/direct/level_follower.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

namespace level_follower_test {

using namespace aula;

namespace {

const Vec3 kSource(0, 0, 0);

/// The energy at a level relative to free field.
Bands energy_at(double level_db, const Vec3& listener) {
    const double r = double{glm::length(listener)};
    return Bands::filled(
        static_cast<float>(std::pow(10, level_db / 10) / (4 * std::numbers::pi * r * r)));
}

double level_db(float energy, const Vec3& listener) {
    return 10 * std::log10(double{energy} / double{energy_at(0, listener)[0]});
}

Vec3 place(double walked_m) { return {4, static_cast<float>(walked_m), 0}; }

}  // namespace

TEST_CASE("levels follow a step of the model over the distance that their slopes allow") {
    for (const double step_db : {-6.0, 6.0}) {
        LevelFollower follower;
        follower.follow(kSource, place(0), energy_at(-20, place(0)), false);
        CHECK(follower.is_exact());
        std::array<double, kBandCount> last;
        last.fill(-20);
        for (int cm = 1; cm <= 45; ++cm) {
            const Vec3 listener = place(0.01 * cm);
            const Bands energy =
                follower.follow(kSource, listener, energy_at(-20 + step_db, listener), false);
            for (std::size_t b = 0; b < kBandCount; ++b) {
                const double now = level_db(energy[b], listener);
                const double most_db = 0.01 * LevelFollower::kSlope_db_m[b];
                const double rest_db = std::abs(-20 + step_db - last[b]);
                CHECK(std::abs(now - last[b]) ==
                      Approx(std::min(most_db, rest_db)).margin(0.011));  // kReached_db
                last[b] = now;
            }
        }
        CHECK(follower.is_exact());
        CHECK(last[0] == Approx(-20 + step_db).margin(1e-4));
    }
}

TEST_CASE("levels follow a large step by 2 % of the rest in each centimetre walked") {
    LevelFollower follower;
    follower.follow(kSource, place(0), energy_at(-50, place(0)), false);
    double last = -50;
    for (int cm = 1; cm <= 20; ++cm) {
        const Vec3 listener = place(0.01 * cm);
        const double now = level_db(
            follower.follow(kSource, listener, energy_at(0, listener), false)[0], listener);
        // 2e-3: the walk in single precision, times 100 dB per metre.
        CHECK(now - last == Approx(-0.02 * last).margin(2e-3));
        last = now;
    }
}

TEST_CASE("slopes of the model below the bound, and those of free field, pass to the bit") {
    LevelFollower follower;
    for (int cm = 0; cm < 350; ++cm) {
        const Vec3 listener(4 - 0.01F * static_cast<float>(cm), 0, 0);
        const Bands model = energy_at(-0.14 * cm, listener);
        CHECK(follower.follow(kSource, listener, model, false) == model);
    }
}

TEST_CASE("at rest, and where an object moves, the pressure moves half-way in each frame") {
    for (const bool has_moved : {false, true}) {
        LevelFollower follower;
        follower.follow(kSource, place(0), Bands{}, false);
        const Bands model = energy_at(-20, place(0));
        double share = 0;
        for (int frame = 0; frame < 9; ++frame) {
            const Bands energy = follower.follow(kSource, place(0), model, has_moved);
            share = 0.5 * (1 + share);
            // 1e-3: pressure at the level that counts as silence.
            CHECK(std::sqrt(double{energy[0]} / double{model[0]}) == Approx(share).margin(2e-3));
        }
        for (int frame = 0; frame < 3; ++frame) {
            follower.follow(kSource, place(0), model, has_moved);
        }
        CHECK(follower.is_exact());
        CHECK(follower.energy() == model);
        for (int frame = 0; frame < 12; ++frame) {
            follower.follow(kSource, place(0), Bands{}, has_moved);
        }
        CHECK(follower.is_exact());
        CHECK(follower.energy() == Bands{});
    }
}

TEST_CASE("after a jump of an end the energies are those of the model") {
    LevelFollower follower;
    follower.follow(kSource, place(0), energy_at(-20, place(0)), false);
    CHECK(follower.follow(kSource, place(1), energy_at(-3, place(1)), false) ==
          energy_at(-3, place(1)));
    follower.follow(kSource, place(1.1), energy_at(-20, place(1.1)), false);
    CHECK_FALSE(follower.is_exact());
}

}  // namespace level_follower_test
