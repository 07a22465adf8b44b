#include "apps/room/remote/adm_osc.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "tests/support/test_scenes.h"

using namespace aula;
using namespace aula::test;

namespace {

using Arguments = std::vector<std::variant<double, std::string>>;

/// The small room (5 x 4 x 3 m, listener at (3.7, 2.9, 1.2)) with three sources.
Scene three_sources() {
    Scene scene = small_room();
    for (const char* const name : {"second", "third"}) {
        scene.sources.push_back(scene.sources[0]);
        scene.sources.back().name = name;
    }
    scene.sources[2].gain_db = -6;
    return scene;
}

/// Messages for the objects of a scene, and the controls that they change.
struct Objects {
    explicit Objects(const AdmRegion& region = {three_sources(), {}})
        : adm(three_sources(), region) {
        present.listener = three_sources().listener.pose;
    }

    std::vector<OscAnswer> send(const std::string& address, const Arguments& arguments = {}) {
        return adm.handle({.address = address, .arguments = arguments, .sender = {}}, controls,
                          present);
    }

    /// The numbers of the only answer to a query.
    std::vector<double> ask(const std::string& address) {
        const std::vector<OscAnswer> answers = send(address);
        REQUIRE(answers.size() == 1);
        CHECK(answers[0].message.address == address);
        REQUIRE(answers[0].types.size() == answers[0].message.arguments.size());
        std::vector<double> numbers;
        for (std::size_t i = 0; i < answers[0].types.size(); ++i)
            numbers.push_back(answers[0].message.number(i).value());
        return numbers;
    }

    Vec3 position(std::size_t source) const { return controls.source(source).position.value(); }

    AdmOsc adm;
    PlayControls controls;
    PresentPoses present;
};

/// Rounding of a few operations in single precision at up to 10 m.
constexpr float kRounding_m = 1e-5F;

void check_near(const Vec3& a, const Vec3& b) {
    for (int axis = 0; axis < 3; ++axis) {
        INFO("axis " << axis);
        CHECK(std::abs(a[axis] - b[axis]) <= kRounding_m);
    }
}

}  // namespace

TEST_CASE("ADM-OSC: the region is that of the listener and the room, or as given") {
    const AdmRegion room(three_sources(), {});
    check_near(room.origin, {3.7F, 2.9F, 1.2F});
    CHECK(room.radius_m == 2.5F);
    CHECK(room.text() == "ADM-OSC: origin 3.7, 2.9, 1.2 m, radius 2.5 m");
    const AdmRegion given(three_sources(), {.adm_origin = Vec3(1, 2, 3), .adm_radius_m = 4.0F});
    CHECK(given.origin == Vec3(1, 2, 3));
    CHECK(given.radius_m == 4);
    const AdmRegion free(free_field({0, 3, 4}), {});
    CHECK(free.radius_m == 5);
}

TEST_CASE("ADM-OSC: x is to the right, y to the front, z up, and azimuth to the left") {
    Objects objects({three_sources(), {.adm_origin = Vec3(1, 2, 3), .adm_radius_m = 4.0F}});
    const auto placed = [&](const std::string& parameter, const Arguments& arguments) {
        objects.send("/adm/obj/2/" + parameter, arguments);
        return objects.position(1) - Vec3(1, 2, 3);
    };
    check_near(placed("xyz", {1.0, 0.0, 0.0}), {0, -4, 0});
    check_near(placed("xyz", {0.0, 1.0, 0.0}), {4, 0, 0});
    check_near(placed("xyz", {0.0, 0.0, 1.0}), {0, 0, 4});
    check_near(placed("xyz", {0.5, -0.25, 0.75}), {-1, -2, 3});
    check_near(placed("x", {-1.0}), {-1, 4, 3});
    check_near(placed("y", {0.5}), {2, 4, 3});
    check_near(placed("z", {0.0}), {2, 4, 0});
    check_near(placed("xy", {0.25, 0.75}), {3, -1, 0});
    check_near(placed("aed", {90.0, 0.0, 0.5}), {0, 2, 0});
    check_near(placed("aed", {0.0, 90.0, 1.0}), {0, 0, 4});
    check_near(placed("aed", {0.0, 0.0, 1.0}), {4, 0, 0});
    check_near(placed("azim", {-90.0}), {0, -4, 0});
    const float half = 4 * std::sqrt(0.5F);
    check_near(placed("elev", {45.0}), {0, -half, half});
    check_near(placed("dist", {0.25}), {0, -half / 4, half / 4});
    CHECK_FALSE(objects.controls.source(0).position);
    CHECK_FALSE(objects.controls.source(2).position);
}

TEST_CASE("ADM-OSC: an object at the origin keeps its direction") {
    Objects objects;
    objects.send("/adm/obj/1/aed", {-30.0, 20.0, 1.0});
    const Vec3 before = objects.position(0);
    objects.send("/adm/obj/1/dist", {0.0});
    check_near(objects.position(0), objects.adm.region().origin);
    objects.send("/adm/obj/1/dist", {1.0});
    check_near(objects.position(0), before);
    objects.send("/adm/obj/1/elev", {90.0});
    objects.send("/adm/obj/1/elev", {20.0});
    check_near(objects.position(0), before);
}

TEST_CASE("ADM-OSC: values out of range are clamped, and none is an error") {
    Objects objects({three_sources(), {.adm_origin = Vec3(0), .adm_radius_m = 1.0F}});
    const double inf = std::numeric_limits<double>::infinity();
    objects.send("/adm/obj/1/xyz", {7.0, -1e30, inf});
    check_near(objects.position(0), {-1, -1, 1});
    objects.send("/adm/obj/1/aed", {270.0, -100.0, 5.0});
    check_near(objects.position(0), {0, 0, -1});
    objects.send("/adm/obj/1/gain", {-1.0});
    CHECK(objects.controls.source(0).gain_db == -std::numeric_limits<float>::infinity());
    objects.send("/adm/obj/1/gain", {inf});
    CHECK(objects.controls.source(0).gain_db == 60.0F);
    objects.send("/adm/obj/1/mute", {9.0});
    CHECK(objects.controls.source(0).muted);
    objects.send("/adm/lis/ypr", {400.0, 0.0, -400.0});
    CHECK(objects.controls.listener->yaw_rad == Approx(M_PI));
    CHECK(objects.controls.listener->roll_rad == Approx(-M_PI));
    // Not a number, too few arguments, other types: no change.
    const Vec3 before = objects.position(0);
    const double nan = std::numeric_limits<double>::quiet_NaN();
    for (const Arguments& wrong :
         {Arguments{nan, 0.0, 0.0}, Arguments{0.0, 0.0}, Arguments{"a", 0.0, 0.0}})
        for (const char* parameter : {"xyz", "aed"})
            objects.send(std::string("/adm/obj/1/") + parameter, wrong);
    CHECK(objects.position(0) == before);
    for (const char* absent :
         {"/adm/obj/0/xyz", "/adm/obj/4/xyz", "/adm/obj/-1/xyz", "/adm/obj/01/xyz", "/adm/obj//xyz",
          "/adm/obj/1", "/adm/obj/1/", "/adm/obj/1/zzz", "/adm/lis/abc", "/adm/"}) {
        objects.send(absent, {0.1, 0.1, 0.1});
        CHECK(objects.send(absent).empty());
    }
    CHECK(objects.position(0) == before);
}

TEST_CASE("ADM-OSC: positions stay within the coordinates of a scene at any scale") {
    AdmRegion region(three_sources(), {});
    region.radius_m = 1e6F;
    Objects objects(region);
    const auto within = [](const Vec3& position) {
        return std::max({std::abs(position.x), std::abs(position.y), std::abs(position.z)}) <= 1e6F;
    };
    objects.send("/adm/lis/xyz", {1.0, 1.0, 1.0});
    CHECK(within(objects.controls.listener.value().position));
    objects.send("/adm/obj/1/xyz", {1.0, -1.0, 1.0});
    CHECK(within(objects.position(0)));
    CHECK(objects.position(0).x < -0.9e6F);
    Objects scaled;
    scaled.send("/adm/obj/2/xyz", {-1.0, 1.0, 1.0});
    scaled.send("/adm/obj/2/dmax", {1e6});
    CHECK(within(scaled.position(1)));
    scaled.send("/adm/obj/2/aed", {45.0, 30.0, 1.0});
    CHECK(within(scaled.position(1)));
}

TEST_CASE("ADM-OSC: gain, mute, dmax and name") {
    Objects objects({three_sources(), {.adm_origin = Vec3(0), .adm_radius_m = 2.0F}});
    CHECK(objects.ask("/adm/obj/1/gain")[0] == Approx(1));
    CHECK(objects.ask("/adm/obj/3/gain")[0] == Approx(0.501187));
    objects.send("/adm/obj/1/gain", {0.5});
    CHECK(objects.controls.source(0).gain_db.value() == Approx(-6.0206));
    CHECK(objects.ask("/adm/obj/1/gain")[0] == Approx(0.5));
    objects.send("/adm/obj/1/gain", {0.0});
    CHECK(objects.ask("/adm/obj/1/gain")[0] == 0);
    objects.send("/adm/obj/1/mute", {1.0});
    const auto mute = objects.send("/adm/obj/1/mute");
    REQUIRE(mute.size() == 1);
    CHECK((mute[0].types == "i" && mute[0].message.number(0) == 1.0));
    objects.send("/adm/obj/1/xyz", {0.0, 1.0, 0.0});
    objects.send("/adm/obj/1/dmax", {10.0});
    check_near(objects.position(0), {10, 0, 0});  // the same coordinates
    CHECK(objects.ask("/adm/obj/1/dmax")[0] == 10);
    CHECK(objects.ask("/adm/obj/2/dmax")[0] == 2);
    objects.send("/adm/obj/2/name", {std::string("kick drum")});
    const auto names = objects.send("/adm/obj/*/name");
    REQUIRE(names.size() == 3);
    CHECK(*names[0].message.text(0) == "source");
    CHECK(*names[1].message.text(0) == "kick drum");
    CHECK(names[2].types == "s");
}

TEST_CASE("ADM-OSC: a message without arguments is a query of the present value") {
    Objects objects({three_sources(), {.adm_origin = Vec3(0), .adm_radius_m = 2.0F}});
    objects.present.sources = {Vec3(1, 1, 0), Vec3(2, 0, 0)};
    objects.present.listener = {.position = {0, -2, 1}, .yaw_rad = 1, .roll_rad = -1};
    const auto near = [&](const std::string& address, const std::vector<double>& expected) {
        const std::vector<double> numbers = objects.ask(address);
        REQUIRE(numbers.size() == expected.size());
        for (std::size_t i = 0; i < numbers.size(); ++i)
            CHECK(numbers[i] == Approx(expected[i]).margin(1e-5));  // rounding, degrees
    };
    near("/adm/obj/1/xyz", {-0.5, 0.5, 0});
    near("/adm/obj/1/aed", {45, 0, std::sqrt(0.5)});
    near("/adm/obj/1/azim", {45});
    near("/adm/obj/2/xy", {0, 1});
    near("/adm/obj/3/x", {-1.1 / 2});  // before the first frame: the scene's position
    near("/adm/lis/xyz", {1, 0, 0.5});
    near("/adm/lis/ypr", {180 / M_PI, 0, -180 / M_PI});
    objects.send("/adm/obj/1/xyz", {0.25, 0.5, -1.0});
    objects.send("/adm/lis/xyz", {0.0, 0.5, 0.0});
    near("/adm/obj/1/xyz", {0.25, 0.5, -1});
    near("/adm/lis/xyz", {0, 0.5, 0});
    near("/adm/lis/ypr", {180 / M_PI, 0, -180 / M_PI});
    CHECK(objects.send("/adm/obj/1/zzz").empty());
}

TEST_CASE("ADM-OSC: wildcards select objects") {
    Objects objects;
    for (const auto& [pattern, count] : std::vector<std::pair<std::string, int>>{{"*", 3},
                                                                                 {"?", 3},
                                                                                 {"[1-2]", 2},
                                                                                 {"[!1]", 2},
                                                                                 {"{1,3}", 2},
                                                                                 {"1", 1},
                                                                                 {"??", 0},
                                                                                 {"**", 3},
                                                                                 {"{1", 0},
                                                                                 {"[1", 0},
                                                                                 {"[]", 0},
                                                                                 {"{}", 0},
                                                                                 {"{,1}*", 3},
                                                                                 {"[3-1]", 0}}) {
        INFO(pattern);
        CHECK(objects.send("/adm/obj/" + pattern + "/gain").size() ==
              static_cast<std::size_t>(count));
    }
    objects.send("/adm/obj/[2-3]/mute", {1.0});
    CHECK_FALSE(objects.controls.source(0).muted);
    CHECK(objects.controls.source(1).muted);
    CHECK(objects.controls.source(2).muted);
    // A pattern with many alternatives ends.
    std::string pattern;
    for (int i = 0; i < 5000; ++i) pattern += "{,,1}*";
    CHECK_FALSE(matches(pattern, "111111112"));
    std::string stars(50'000, '*');
    stars += 'x';
    CHECK_FALSE(matches(stars, "1"));
}

TEST_CASE("ADM-OSC: the listener moves and turns as its messages say") {
    Objects objects({three_sources(), {.adm_origin = Vec3(1, 1, 1), .adm_radius_m = 2.0F}});
    const Pose before = objects.present.listener;
    objects.send("/adm/lis/ypr", {90.0, 30.0, -10.0});
    Pose pose = objects.controls.listener.value();
    CHECK(pose.position == before.position);
    check_near(Vec3(pose.yaw_rad, pose.pitch_rad, pose.roll_rad),
               Vec3(90, 30, -10) * (std::numbers::pi_v<float> / 180));
    objects.send("/adm/lis/xyz", {1.0, 0.5, -0.5});
    pose = objects.controls.listener.value();
    check_near(pose.position, {2, -1, 0});
    CHECK(pose.yaw_rad == Approx(M_PI / 2));
}
