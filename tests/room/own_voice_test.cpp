// The listener's own voice: a talker at the mouth that moves and turns with the head.
#include <array>
#include <catch2/catch.hpp>
#include <cmath>

#include "audio/dsp/fft.h"
#include "aula/measurement.h"
#include "tests/support/test_scenes.h"

namespace own_voice_test {

using namespace aula;
using test::free_field;

namespace {

constexpr double kRate_hz = 48000;

/// A free field, in which the listener has a talker at the mouth.
Scene talking(const Pose& head) {
    Scene scene = free_field({});
    scene.listener.pose = head;
    scene.sources[0].from_listener = Vec3(0.1F, 0, -0.08F);
    scene.sources[0].directivity = *Directivity::find("talker");
    scene.attach_sources();
    return scene;
}

Pose head(float yaw_rad, float pitch_rad = 0, float roll_rad = 0) {
    return {{1, 2, 1.6F}, yaw_rad, pitch_rad, roll_rad};
}

/// Levels of both ears between two frequencies, dB re a unit impulse.
std::array<double, 2> ear_levels_db(const Scene& scene, double from_hz, double to_hz) {
    const auto measurement = measure(scene, {.frames = 1, .parameters = false});
    const auto ears =
        ImpulseResponses(*measurement, {.output = OutputFormat::binaural}).response(0);
    constexpr std::size_t kSize = 8192;
    std::array<double, 2> levels_db{};
    for (std::size_t e = 0; e < 2; ++e) {
        std::vector<float> signal = ears[e];
        signal.resize(kSize);
        RealFft fft(kSize);
        std::vector<std::complex<float>> spectrum(fft.bins());
        fft.forward(signal.data(), spectrum.data());
        double sum = 0;
        int count = 0;
        for (std::size_t k = 0; k < spectrum.size(); ++k) {
            const double f = static_cast<double>(k) * kRate_hz / kSize;
            if (f < from_hz || f > to_hz) continue;
            sum += double{std::norm(spectrum[k])};
            ++count;
        }
        levels_db[e] = 10 * std::log10(sum / count);
    }
    return levels_db;
}

}  // namespace

TEST_CASE("The own voice is equal at both ears, and the same whatever way the head turns") {
    for (const auto& [from_hz, to_hz] : {std::pair(350.0, 1400.0), {1400.0, 5600.0}}) {
        const auto ahead = ear_levels_db(talking(head(0)), from_hz, to_hz);
        // KEMAR's ears differ by up to 1 dB for sound from the front.
        CHECK(ahead[0] == Approx(ahead[1]).margin(1));
        for (const Pose& turned :
             {head(1.2F), head(3.1F), head(-2, 0.6F), head(0.5F, -0.4F, 0.3F)}) {
            const auto levels = ear_levels_db(talking(turned), from_hz, to_hz);
            // Rounding of directions, which choose between measured ones.
            for (std::size_t e = 0; e < 2; ++e) CHECK(levels[e] == Approx(ahead[e]).margin(0.2));
        }
        // Companion: a mouth that stays behind when the head turns is heard at one side.
        Scene left_behind = talking(head(0));
        left_behind.listener.pose.yaw_rad = 1.5F;
        const auto levels = ear_levels_db(left_behind, from_hz, to_hz);
        CHECK(std::abs(levels[0] - levels[1]) > 6);
    }
}

TEST_CASE("The own voice is as loud as from 16 cm behind a talker, and duller than for others") {
    const Scene own = talking(head(0));
    Scene other = own;
    other.sources[0].from_listener.reset();
    other.sources[0].set_pose({{2, 2, 1.6F}, 3.14159F, 0, 0});  // at 1 m, facing the listener
    const auto above_db = [&](double from_hz, double to_hz) {
        return ear_levels_db(own, from_hz, to_hz)[0] - ear_levels_db(other, from_hz, to_hz)[0];
    };
    // From the mouth to an ear are 16 cm: 20 lg(1 / 0.16) = 16 dB. The talker is 1 to 2 dB softer
    // to the rear, and KEMAR by as much for sound from below.
    const double low_db = above_db(180, 355);
    CHECK(low_db > 11);
    CHECK(low_db < 16);
    CHECK(above_db(5600, 11200) < low_db - 4);
}

TEST_CASE("A wall hears the own voice of a head that faces it") {
    const auto reflected = [](float yaw_rad) {
        Scene scene = talking(head(yaw_rad));
        Object wall;
        wall.vertices = {{3, -3, -2}, {3, 7, -2}, {3, 7, 6}, {3, -3, 6}};
        wall.triangles = {{0, 1, 2}, {0, 2, 3}};
        wall.triangle_materials = {0, 0};
        scene.objects.push_back(wall);
        scene.materials.push_back({"wall", Bands::filled(0.1F), Bands::filled(0)});
        scene.simulation.diffraction_order = 0;
        const auto measurement = measure(scene, {.frames = 1, .parameters = false});
        for (const SoundPath& path : measurement->response(0).paths)
            if (path.order == 1) return path.energy;
        return Bands{};
    };
    const Bands facing = reflected(0);
    const Bands turned_away = reflected(3.14159F);
    const Directivity talker = *Directivity::find("talker");
    for (std::size_t band = 0; band < kBandCount; ++band) {
        // The mouth is 10 cm nearer to the wall, or farther from it, on a way of 4 m.
        const float nearer = 4.1F * 4.1F / (3.9F * 3.9F);
        const float expected =
            nearer * talker.factor({1, 0, 0})[band] / talker.factor({-1, 0, 0})[band];
        // The sound leaves the mouth a degree off the front.
        CHECK(facing[band] / turned_away[band] == Approx(expected).epsilon(0.05));
    }
    CHECK(facing[7] / turned_away[7] > 4);
}

}  // namespace own_voice_test
