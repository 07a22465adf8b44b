#include "apps/session/session.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "audio/sound_file.h"
#include "tests/support/program.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/test_scenes.h"

namespace {

using namespace aula;
using test::free_field;
using test::TemporaryFolder;

constexpr std::size_t kBlock = 256;

/// A mono rendering of a scene, one second long.
std::vector<float> rendered(const Scene& scene) {
    const TemporaryFolder folder;
    const auto file = folder.path() / "out.wav";
    SessionOptions options;
    options.output = OutputFormat::mono;
    options.block = kBlock;
    options.duration_s = 1;
    REQUIRE(Session(scene, options).render(file));
    return read_sound(file, 48000).samples;
}

}  // namespace

TEST_CASE("A pose takes effect in the block that contains its frame's time") {
    Scene scene = free_field({1, 0, 0});
    scene.sources[0].signal = Source::Signal::noise;
    const auto standing = rendered(scene);
    // The listener steps aside between the frames at 14/30 and 15/30 s.
    const Pose here;
    Pose there;
    there.position = {-1, 0, 0};
    scene.listener.path = Path{{{0, here}, {0.48, here}, {0.49, there}}, false};
    const auto stepping = rendered(scene);
    REQUIRE(standing.size() == 48000);
    REQUIRE(stepping.size() == 48000);
    const auto differ = std::mismatch(standing.begin(), standing.end(), stepping.begin()).first;
    const auto first = static_cast<std::size_t>(differ - standing.begin());
    // 15/30 s is sample 24000.
    REQUIRE(first / kBlock == 24000 / kBlock);
}

TEST_CASE("A listener at twice the distance hears half the pressure, later") {
    Scene scene = free_field({3.432F, 0, 0});
    const auto near = rendered(scene);
    scene.sources[0].position.x *= 2;
    const auto far = rendered(scene);
    // 0.1 dB: rounding in the design of the filters.
    REQUIRE(static_cast<double>(near[480]) == Approx(1 / 3.432).epsilon(0.0116));
    REQUIRE(static_cast<double>(far[960]) == Approx(0.5 / 3.432).epsilon(0.0116));
}

TEST_CASE("A rendering ends however many frames the renderer holds") {
    // Frames that come faster than the long levels of the convolver go over to them.
    Scene scene = test::small_room();
    scene.sources.push_back(scene.sources[0]);
    scene.sources[1].name = "other";
    scene.sources[1].position = {4, 3, 2};
    scene.simulation.rays = 10;
    scene.simulation.ir_length_s = 1.5F;
    scene.simulation.frame_rate_hz = GENERATE(30.0F, 60.0F, 100.0F);
    SessionOptions options;
    options.output = OutputFormat::mono;
    options.block = GENERATE(32, 1024);
    options.duration_s = 0.6;
    const TemporaryFolder folder;
    const auto file = folder.path() / "out.wav";
    REQUIRE(Session(scene, options).render(file));
    CHECK(sound_info(file).frames == 28800);
}

TEST_CASE("A rendering that is stopped leaves nothing behind") {
    const TemporaryFolder folder;
    Session session(free_field({1, 0, 0}), {});
    REQUIRE_FALSE(session.render(folder.path() / "out.wav", [](double) { return false; }));
    REQUIRE(test::names_in(folder.path()).empty());
}
