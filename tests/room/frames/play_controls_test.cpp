#include "apps/room/frames/play_controls.h"

#include <catch2/catch.hpp>

#include "tests/support/live_take.h"
#include "tests/support/test_scenes.h"
#include "tests/support/tone.h"

using namespace aula;
using namespace aula::test;

namespace {

/// Energy of one second of noise in a room.
double energy(const PlayControls& controls) {
    Scene scene = small_room();
    scene.simulation.rays = 200;
    scene.sources[0].signal = Source::Signal::noise;
    PlaybackOptions options;
    options.output = OutputFormat::mono;
    LiveTake live;
    const auto prepared = live.prepare(scene, options);
    double sum = 0;
    for (const float x : live.take(100, [&](int block) {
             if (block == 0) live.begin(*prepared, controls);
         }))
        sum += static_cast<double>(x) * static_cast<double>(x);
    return sum;
}

}  // namespace

TEST_CASE("Parts of the sound can be omitted, and a source attenuated or moved") {
    const double all = energy({});
    PlayControls controls;
    controls.direct = controls.early = controls.late = false;
    CHECK(energy(controls) == 0);  // exact: gains of zero
    controls.direct = true;
    const double direct = energy(controls);
    CHECK(direct > 0);
    controls.wet = 0;
    CHECK(energy(controls) == Approx(direct));
    controls.wet = 1;
    CHECK(energy(controls) == 0);
    controls = {};
    controls.late = false;
    const double discrete = energy(controls);
    CHECK(discrete > direct);
    CHECK(discrete < all);

    controls = {};
    controls.sources.resize(1);
    controls.sources[0].gain_db = -20;
    CHECK(energy(controls) == Approx(all / 100).epsilon(1e-4));  // rounding
    controls.sources[0] = {};
    controls.sources[0].position = Vec3(3.6F, 2.8F, 1.2F);  // close to the listener's ear
    CHECK(energy(controls) > 4 * all);
}

TEST_CASE("A muted source is inaudible, and a source with solo mutes all others") {
    PlayControls controls;
    CHECK(controls.audible(0));
    CHECK(controls.audible(5));
    controls.sources.resize(2);
    controls.sources[0].muted = true;
    CHECK_FALSE(controls.audible(0));
    CHECK(controls.audible(1));
    controls.sources[0] = {};
    controls.sources[1].solo = true;
    CHECK_FALSE(controls.audible(0));
    CHECK(controls.audible(1));
    controls.sources[1].muted = true;
    CHECK_FALSE(controls.audible(1));
}

TEST_CASE("A source on the listener follows the user's walk until the user moves it") {
    Scene scene = small_room();
    scene.sources[0].from_listener = Vec3(0.1F, 0, 0);
    scene.attach_sources();
    PlayControls controls;
    CHECK(controls.source_at(scene, 0, 1).position ==
          scene.listener.pose.position + Vec3(0.1F, 0, 0));
    Pose walked;
    walked.position = {1, 2, 1.5F};
    walked.yaw_rad = 1.5F;
    controls.listener = walked;
    CHECK(same_pose(controls.source_at(scene, 0, 1), walked.at({0.1F, 0, 0})));
    controls.sources.resize(1);
    controls.sources[0].position = Vec3(4, 3, 1);
    CHECK(same_pose(controls.source_at(scene, 0, 1), Pose{{4, 3, 1}, 0, 0, 0}));
    // Turned alone it is still there, and does not turn with the head.
    controls.sources[0] = {};
    controls.sources[0].angles_rad = Vec3(0.5F, 0, 0);
    CHECK(controls.source_at(scene, 0, 1).position == walked.at({0.1F, 0, 0}).position);
    CHECK(controls.source_at(scene, 0, 1).yaw_rad == 0.5F);
    // Companion: other sources stay where they are.
    scene.sources[0].from_listener.reset();
    controls.sources.clear();
    CHECK(controls.source_at(scene, 0, 1).position == scene.sources[0].position);
}
