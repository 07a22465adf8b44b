#include "apps/room/offline/offline.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <cstdio>
#include <numbers>
#include <string>

#include "aula/audio/sound_file.h"
#include "aula/engine/impulse_response.h"
#include "aula/engine/propagation.h"
#include "aula/measurement.h"
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
    PlaybackOptions options;
    options.output = OutputFormat::mono;
    options.block = kBlock;
    options.duration_s = 1;
    REQUIRE(render_offline(scene, options, file));
    return read_sound(file, 48000).samples;
}

/// A small room with reverberation only and two sources in opposite corners.
Scene reverberant_room() {
    Scene scene = test::small_room();
    scene.simulation.direct = false;
    scene.simulation.specular = false;
    scene.simulation.rays = 150;
    scene.sources[0].name = "left";
    scene.sources[0].position = {0.3F, 0.3F, 0.3F};
    scene.sources.push_back(scene.sources[0]);
    scene.sources[1].name = "right";
    scene.sources[1].position = {4.7F, 3.7F, 2.7F};
    return scene;
}

/// The mono impulse response of the source of that name.
std::vector<float> measured(const Scene& scene, const std::string& name) {
    std::size_t source = 0;
    while (scene.sources[source].name != name) ++source;
    const auto measurement = measure(scene, {.frames = 15});
    return ImpulseResponses(*measurement, {.output = OutputFormat::mono}).response(source)[0];
}

double product(const std::vector<float>& a, const std::vector<float>& b) {
    double sum = 0;
    for (std::size_t n = 0; n < std::min(a.size(), b.size()); ++n)
        sum += static_cast<double>(a[n]) * static_cast<double>(b[n]);
    return sum;
}

double correlation(const std::vector<float>& a, const std::vector<float>& b) {
    return product(a, b) / std::sqrt(product(a, a) * product(b, b));
}

/// The level of a steady tone's reverberation.
double tail_level_db(const ImpulseResponse& response, double frequency_hz) {
    std::complex<double> sum = 0;
    const double step = 2 * std::numbers::pi * frequency_hz / response.sample_rate_hz;
    const std::vector<float>& pressure = response.channels[0];
    for (std::size_t n = 0; n < pressure.size(); ++n)
        sum += static_cast<double>(pressure[n]) * std::polar(1.0, -step * static_cast<double>(n));
    return 10 * std::log10(std::norm(sum));
}

double standard_deviation(const std::vector<double>& values) {
    double mean = 0;
    for (const double x : values) mean += x / static_cast<double>(values.size());
    double squares = 0;
    for (const double x : values) squares += (x - mean) * (x - mean);
    return std::sqrt(squares / static_cast<double>(values.size() - 1));
}

}  // namespace

TEST_CASE("A pose takes effect at the first sample at or after its frame's time") {
    Scene scene = free_field({1, 0, 0});
    scene.sources[0].signal = Source::Signal::noise;
    const auto standing = rendered(scene);
    // The listener steps aside between the frames at 14/30 and 15/30 s.
    const Pose here;
    Pose there;
    there.position = {-1, 0, 0};
    scene.listener.path = Trajectory{{{0, here}, {0.48, here}, {0.49, there}}, false};
    const auto stepping = rendered(scene);
    REQUIRE(standing.size() == 48000);
    REQUIRE(stepping.size() == 48000);
    const auto differ = std::mismatch(standing.begin(), standing.end(), stepping.begin()).first;
    const auto first = static_cast<std::size_t>(differ - standing.begin());
    // 15/30 s is sample 24000. The first weights of a fade may round to zero.
    REQUIRE(first >= 24000);
    REQUIRE(first < 24000 + 4);
}

TEST_CASE("A rendering has the same samples for every block") {
    Scene scene = test::small_room();
    scene.sources[0].signal = Source::Signal::noise;
    scene.simulation.rays = 50;
    Pose there = scene.listener.pose;
    there.position.x -= 1;
    there.yaw_rad = 1;
    scene.listener.path = Trajectory{{{0, scene.listener.pose}, {0.5, there}}, false};
    const auto samples = [&](int block) {
        const TemporaryFolder folder;
        const auto file = folder.path() / "out.wav";
        PlaybackOptions options;
        options.block = block;
        options.duration_s = 0.4;
        REQUIRE(render_offline(scene, options, file));
        return read_sound(file, 48000).samples;
    };
    const std::vector<float> reference = samples(256);
    for (const int block : {16, 17, 4096}) CHECK((samples(block) == reference));
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

TEST_CASE("A rendering ends for any number of frames that the renderer holds") {
    // Frames at a higher rate than the long levels of the convolver can exchange filters.
    Scene scene = test::small_room();
    scene.sources.push_back(scene.sources[0]);
    scene.sources[1].name = "other";
    scene.sources[1].position = {4, 3, 2};
    scene.simulation.rays = 10;
    scene.simulation.ir_length_s = 1.5F;
    scene.simulation.frame_rate_hz = GENERATE(30.0F, 60.0F, 100.0F);
    PlaybackOptions options;
    options.output = OutputFormat::mono;
    options.block = GENERATE(32, 1024);
    options.duration_s = 0.6;
    const TemporaryFolder folder;
    const auto file = folder.path() / "out.wav";
    REQUIRE(render_offline(scene, options, file));
    CHECK(sound_info(file).samples == 28800);
}

TEST_CASE("Samples that are not finite are rendered as silence, with a warning") {
    Scene scene = free_field({1, 0, 0});
    scene.sources[0].signal = Source::Signal::noise;
    scene.sources[0].gain_db = 1000;
    const TemporaryFolder folder;
    const auto file = folder.path() / "out.wav";
    PlaybackOptions options;
    options.output = OutputFormat::mono;
    options.duration_s = 0.1;
    options.format = GENERATE(SampleFormat::float32, SampleFormat::pcm16);
    const auto warnings = render_offline(scene, options, file);
    REQUIRE(warnings.has_value());
    REQUIRE(warnings->size() == 1);
    CHECK(warnings->front().find("not finite") != std::string::npos);
    // A sample that was not finite would be a warning.
    CHECK(read_sound(file, 48000).warnings.empty());
}

TEST_CASE("A stopped rendering leaves no file") {
    const TemporaryFolder folder;
    REQUIRE_FALSE(render_offline(free_field({1, 0, 0}), {}, folder.path() / "out.wav",
                                 [](double) { return false; }));
    REQUIRE(test::names_in(folder.path()).empty());
}

TEST_CASE("The reverberations of two sources in opposite corners are uncorrelated") {
    const Scene scene = reverberant_room();
    const auto left = measured(scene, "left");
    const auto right = measured(scene, "right");
    // Statistical: 24 kHz, of which scattering and air leave the lower half, for 1 / 6.9 of 0.3 s:
    // 500 degrees of freedom or more, 2.2 % or less at 48 kHz.
    CHECK(std::abs(correlation(left, right)) < 0.1);
    std::vector<float> both(left.size());
    for (std::size_t n = 0; n < left.size(); ++n) both[n] = left[n] + right[n];
    // By 3 dB: 10 lg(1 + 0.1) is the uncertainty by the correlation.
    const double apart = product(left, left) + product(right, right);
    CHECK(10 * std::log10(product(both, both) / apart) == Approx(0).margin(0.42));
    // Companion: with equal names they agree except for their energies.
    Scene same = scene;
    same.sources[1].name = "left";
    same.sources[0].name = "another";
    CHECK(correlation(left, measured(same, "left")) > 0.5);
}

TEST_CASE("A source has the same response alone and among others, measured and rendered") {
    const Scene scene = reverberant_room();
    Scene reversed = scene;
    std::swap(reversed.sources[0], reversed.sources[1]);
    Scene alone = scene;
    alone.sources.erase(alone.sources.begin());
    const auto reference = measured(scene, "right");
    // The energies of 150 rays per frame deviate by a few per cent per bin, and so does the shaped
    // noise: the correlation remains above 0.95, with other carriers it is below 0.1.
    for (const Scene& other : {reversed, alone})
        CHECK(correlation(measured(other, "right"), reference) > 0.95);
    for (Scene other : {scene, reversed, alone}) {
        for (Source& source : other.sources)
            if (source.name != "right") source.gain_db = -300;
        CHECK(correlation(rendered(other), reference) > 0.95);
    }
    // With the same energies, to the bit.
    const auto measurement = measure(scene, {.frames = 2});
    Measurement of_one = *measurement;
    of_one.responses.erase(of_one.responses.begin());
    of_one.sources.erase(of_one.sources.begin());
    for (const OutputFormat output : {OutputFormat::mono, OutputFormat::foa}) {
        const OutputOptions options{.output = output};
        CHECK(ImpulseResponses(*measurement, options).response(1) ==
              ImpulseResponses(of_one, options).response(0));
    }
}

TEST_CASE("Along a walk the tail of a tone varies as in a diffuse field") {
    const Scene scene = reverberant_room();
    Propagation propagation(scene, scene.simulation);
    FrameInput input{.sources = {scene.sources[0].position, scene.sources[1].position},
                     .listeners = {Vec3(0)}};
    const auto carriers = make_noise_carriers(48000.0, scene.simulation.seed);
    const double length_s = propagation.response_length_s();
    constexpr std::array kTones_hz{500.0, 1500.0};
    std::array<double, kTones_hz.size()> square{};
    std::array<std::vector<double>, kTones_hz.size()> held_db;
    ImpulseResponse response;
    for (const char* const name : {"left", "middle", "right", "back"}) {
        ImpulseResponseBuilder builder(carriers, scene.medium, length_s, name);
        std::array<std::vector<double>, kTones_hz.size()> walk_db;
        for (int position = 0; position < 20; ++position) {
            input.listeners[0] = Vec3(0.5F + 0.2F * static_cast<float>(position), 2, 1.5F);
            propagation.step(input);
            EnergyResponse energy = propagation.response(0);
            builder.build(energy, response);
            for (std::size_t t = 0; t < kTones_hz.size(); ++t)
                walk_db[t].push_back(tail_level_db(response, kTones_hz[t]));
            if (name != std::string("left")) continue;
            energy.listener = Vec3(0);
            builder.build(energy, response);
            for (std::size_t t = 0; t < kTones_hz.size(); ++t)
                held_db[t].push_back(tail_level_db(response, kTones_hz[t]));
        }
        for (std::size_t t = 0; t < kTones_hz.size(); ++t)
            square[t] += std::pow(standard_deviation(walk_db[t]), 2) / 4;
    }
    for (std::size_t t = 0; t < kTones_hz.size(); ++t) {
        // The energy of a tone in a diffuse field is exponentially distributed. Statistical: the
        // logarithm has a kurtosis of 5.4; the standard deviation of 80 values is known to 12 %.
        const double diffuse_db = 10 / std::log(10.0) * std::numbers::pi / std::sqrt(6.0);
        CAPTURE(kTones_hz[t], std::sqrt(square[t]), standard_deviation(held_db[t]));
        CHECK(std::sqrt(square[t]) == Approx(diffuse_db).epsilon(0.3));
        // Companion: with the carriers of one place.
        CHECK(standard_deviation(held_db[t]) < 0.7 * diffuse_db);
    }
}
