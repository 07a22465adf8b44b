#include "apps/room/live/growing_length.h"

#include <catch2/catch.hpp>

#include "tests/support/rooms.h"

using namespace aula;

namespace {

constexpr double kPeriod_s = 1.0 / 30;

/// A hall that sounds for longer than the longest response, 10 s.
Scene hall() {
    return test::grey_room(test::box(Vec3(30, 20, 10), 0), 0.02F, 0.3F, Vec3(5, 5, 2),
                           Vec3(20, 10, 2));
}

double fitted_s(GrowingLength& length, Scene scene) {
    length.fit(scene, room_length_s(scene));
    return double{scene.simulation.ir_length_s.value_or(0)};
}

/// Plays frames until another length is wanted. Returns the time; -1 if none is within `longest_s`.
double play(GrowingLength& length, double took_s, double longest_s) {
    for (int frame = 1; frame * kPeriod_s < longest_s; ++frame)
        if (length.add(took_s, kPeriod_s)) return frame * kPeriod_s;
    return -1;
}

}  // namespace

TEST_CASE("A live response begins with 4 s and grows while its frames leave time") {
    GrowingLength length;
    CHECK(fitted_s(length, hall()) == 4);
    const auto room = length.hear();
    double last_s = 4;
    for (const double expected_s : {6.0, 9.0, 10.0}) {
        CHECK(play(length, 0.1 * kPeriod_s, 10) > 2);
        // Nothing more is wanted until the room is built.
        CHECK(play(length, 0.1 * kPeriod_s, 10) == -1);
        last_s = fitted_s(length, hall());
        CHECK(last_s == Approx(expected_s));
    }
    CHECK(play(length, 0.1 * kPeriod_s, 300) == -1);
    // It falls where frames take too long, to the first length.
    CHECK(play(length, 1.2 * kPeriod_s, 10) > 0);
    CHECK(fitted_s(length, hall()) < last_s);
    CHECK(play(length, 10 * kPeriod_s, 10) > 0);
    CHECK(fitted_s(length, hall()) == 4);
    CHECK(play(length, 10 * kPeriod_s, 60) == -1);
    // Another room begins anew.
    Scene other = hall();
    other.materials[0].absorption = Bands::filled(0.6F);
    CHECK(fitted_s(length, other) < 2);
    CHECK(fitted_s(length, hall()) == 4);
}

TEST_CASE("While two rooms are heard no length is wanted, nor for one that the scene sets") {
    GrowingLength length;
    CHECK(fitted_s(length, hall()) == 4);
    auto room = length.hear();
    auto next = length.hear();
    CHECK(play(length, 0.1 * kPeriod_s, 60) == -1);
    room.reset();
    CHECK(play(length, 0.1 * kPeriod_s, 60) > 0);
    Scene given = hall();
    given.simulation.ir_length_s = 7;
    CHECK(fitted_s(length, given) == 7);
    CHECK(play(length, 0.1 * kPeriod_s, 60) == -1);
}
