#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "aula/engine/scene_file.h"
#include "tests/room/auralizer/auralizer_rendering.h"

namespace {

using namespace aula;
using namespace aula::test;

/// A shipped scene whose listener hears only the direct sound of a tone while it walks on its path
/// from a time on.
std::vector<float> heard_on_walk(const std::string& name, double from_s, int diffraction_order) {
    Scene scene = load_scene(std::string(AULA_SOURCE_DIR "/scenes/") + name).scene;
    scene.simulation.rays = 1;
    scene.simulation.specular = false;
    scene.simulation.ir_length_s = 0.1F;
    scene.simulation.diffraction_order = diffraction_order;
    AuralizerOptions options = mono();
    options.before_frame = [&scene, from_s](Auralizer& auralizer, double time_s) {
        auralizer.set_listener(scene.listener.pose_at(from_s + time_s));
    };
    Auralizer auralizer(scene, options);
    auralizer.set_part_gains({.direct = 1, .early = 0, .late = 0}, 0);
    return rendered(auralizer, 60000, {256}, tone_at);
}

}  // namespace

TEST_CASE("A walk through a doorway adds no sidebands above -80 dB to a tone") {
    // Out of the shadow of the door frame into sight of the source. The door of the other scene is
    // open until 3 s.
    struct Walk {
        const char* scene;
        double from_s;
    };
    for (const Walk& walk : {Walk{"two_rooms.json", 3.5}, Walk{"door.json", 0.6}}) {
        const std::vector<float> heard = heard_on_walk(walk.scene, walk.from_s, 2);
        const std::vector<float> switched = heard_on_walk(walk.scene, walk.from_s, 0);
        REQUIRE(std::any_of(heard.begin(), heard.end(), [](float x) { return x != 0; }));
        // The fade between frames keeps even a direct sound that appears within one of them below
        // -60 dB: the bound is 20 dB lower, so that this companion misses it.
        const double bound = 1e-8;
        CHECK(share_off_tone(heard) < bound);
        CHECK(share_off_tone(switched) > bound);
    }
}

TEST_CASE("A walk through a doorway adds no lines at the frame rate to a tone") {
    // Interference and the Doppler effect change the tone by less than 25 Hz. Two lines of -60 dB
    // have -57 dB together.
    const auto lines_db = [](double from_s, int diffraction_order) {
        return 10 * std::log10(share_off_tone(
                        heard_on_walk("two_rooms.json", from_s, diffraction_order), 25));
    };
    for (const double from_s : {1.0, 2.0, 2.75, 4.0, 5.0}) {
        CAPTURE(from_s);
        CHECK(lines_db(from_s, 2) < -57);
    }
    // Companion: the direct sound appears within a frame.
    CHECK(lines_db(3.5, 0) > -57);
}
