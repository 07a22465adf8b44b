#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include "tests/room/auralizer/auralizer_rendering.h"

namespace {

using namespace aula;
using namespace aula::test;

constexpr double kWalk_m_s = 0.8;

/// A live room with sources around the listener, who walks away.
Scene live_room(int sources, float frame_rate_hz) {
    Scene scene = small_room();
    scene.materials[0] = {"wall", Bands::filled(0.15F), Bands::filled(0.2F)};
    scene.sources.clear();
    for (int i = 0; i < sources; ++i) {
        Source source;
        source.name = "s" + std::to_string(i);
        const float turn = 0.7F * static_cast<float>(i);
        source.position = {2.5F + 2 * std::cos(turn), 2 + 1.6F * std::sin(turn),
                           1 + 0.15F * static_cast<float>(i)};
        scene.sources.push_back(source);
    }
    scene.simulation.rays = 400;
    scene.simulation.frame_rate_hz = frame_rate_hz;
    return scene;
}

Vec3 place_at(double time_s) {
    return {1.5F + 0.64F * static_cast<float>(time_s), 1 + 0.48F * static_cast<float>(time_s),
            1.6F};
}

/// Poses come with each frame, or at a lower rate.
std::vector<float> heard_on_walk(int sources, float frame_rate_hz, double tone_hz,
                                 double pose_rate_hz) {
    AuralizerOptions options = mono();
    options.before_frame = [=](Auralizer& auralizer, double time_s) {
        Pose pose;
        pose.position = place_at(std::floor(time_s * pose_rate_hz + 0.01) / pose_rate_hz);
        auralizer.set_listener(pose);
    };
    Auralizer auralizer(live_room(sources, frame_rate_hz), options);
    return rendered(auralizer, 120000, {256}, [&](std::int64_t n) {
        return static_cast<float>(
            0.1 * std::sin(2 * std::numbers::pi * tone_hz * static_cast<double>(n) / kRate_hz));
    });
}

/// Energy within `near_hz` of a frequency after the onset, with the window of Blackman and Harris.
double energy_near(const std::vector<float>& samples, double frequency_hz, double near_hz) {
    constexpr std::size_t kFirst = 36000;
    const auto count = static_cast<double>(samples.size() - kFirst);
    std::vector<double> windowed;
    for (std::size_t n = kFirst; n < samples.size(); ++n) {
        const double t = 2 * std::numbers::pi * static_cast<double>(n - kFirst) / count;
        windowed.push_back(double{samples[n]} *
                           (0.35875 - 0.48829 * std::cos(t) + 0.14128 * std::cos(2 * t) -
                            0.01168 * std::cos(3 * t)));
    }
    double energy = 0;
    for (double f = frequency_hz - near_hz; f <= frequency_hz + near_hz; f += kRate_hz / count) {
        const auto step = std::polar(1.0, -2 * std::numbers::pi * f / kRate_hz);
        std::complex<double> sum = 0;
        std::complex<double> phase = 1;
        for (const double x : windowed) {
            sum += x * phase;
            phase *= step;
        }
        energy += std::norm(sum);
    }
    return energy;
}

/// The stronger one of the lines at the rate of the poses beside a tone, re the tone.
double lines_db(int sources, float frame_rate_hz, double tone_hz, double rate_hz) {
    const std::vector<float> heard = heard_on_walk(sources, frame_rate_hz, tone_hz, rate_hz);
    // The shift of the walk, and half of the window's main lobe: four bins of 0.57 Hz.
    const double near_hz = 2.3 + tone_hz * kWalk_m_s / 343;
    const double lines = std::max(energy_near(heard, tone_hz - rate_hz, near_hz),
                                  energy_near(heard, tone_hz + rate_hz, near_hz));
    return 10 * std::log10(lines / energy_near(heard, tone_hz, near_hz));
}

}  // namespace

TEST_CASE("A walk in a live room adds no lines at the frame rate") {
    for (const int sources : {1, 8}) {
        for (const double tone_hz : {440.0, 1500.0, 3313.0}) {
            CAPTURE(sources, tone_hz);
            CHECK(lines_db(sources, 30, tone_hz, 30) < -45);
        }
    }
    for (const int sources : {1, 8}) {
        CAPTURE(sources);
        CHECK(lines_db(sources, 10, 440, 10) < -40);
    }
    // Companion: poses that are held for three frames.
    CHECK(lines_db(1, 30, 440, 10) > -45);
}
