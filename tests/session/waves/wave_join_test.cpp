#include "apps/session/waves/wave_join.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <numbers>
#include <string>
#include <vector>

#include "apps/session/edit/scene_state.h"
#include "audio/dsp/fft.h"
#include "aula/measurement.h"
#include "engine/base/sampling.h"
#include "engine/waves/wall_admittance.h"
#include "tests/engine/waves/exact_box.h"
#include "tests/support/rooms.h"

using namespace aula;

namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kSpeed_m_s = 343.2;
constexpr double kRate_hz = 8000;
const Vec3 kSize(5, 4, 3);
const Vec3 kSource(1.2F, 1.1F, 1.5F);

Scene living_room(float waves_hz) {
    Scene scene = test::grey_room(test::box(kSize), 0.1F, 0.3F, kSource, {3.4F, 2.3F, 1.1F});
    scene.simulation = {};
    scene.simulation.waves_hz = waves_hz;
    scene.simulation.threads = 1;
    return scene;
}

/// The centre of the room, where the modes of 63 Hz have their nodes, and other places.
std::vector<Pose> receivers() {
    std::vector<Pose> poses(4);
    poses[0].position = kSize / 2.0F;
    poses[1].position = {3.4F, 2.3F, 1.1F};
    poses[2].position = {4.6F, 3.5F, 0.5F};
    poses[3].position = {0.6F, 3.1F, 2.2F};
    return poses;
}

/// An octave with steep flanks: the share of energy between two frequencies over their distance.
double octave_energy(const std::vector<std::complex<double>>& field, double from_hz, double step_hz,
                     double centre_hz) {
    double sum = 0;
    int count = 0;
    for (std::size_t i = 0; i < field.size(); ++i) {
        const double hz = from_hz + step_hz * static_cast<double>(i);
        if (hz < centre_hz / std::numbers::sqrt2 || hz > centre_hz * std::numbers::sqrt2) continue;
        sum += std::norm(field[i]);
        ++count;
    }
    return sum / count;
}

double db(double ratio) { return 10 * std::log10(ratio); }

/// The mean of |H|^2 of a signal over an octave.
double octave_energy(const std::vector<float>& signal, double centre_hz) {
    const std::size_t size = fast_fft_size(4 * signal.size());
    std::vector<float> padded = signal;
    padded.resize(size);
    RealFft fft(size);
    std::vector<std::complex<float>> spectrum(fft.bins());
    fft.forward(padded.data(), spectrum.data());
    const std::vector<std::complex<double>> field(spectrum.begin(), spectrum.end());
    return octave_energy(field, 0, kRate_hz / static_cast<double>(size), centre_hz);
}

}  // namespace

TEST_CASE("wave_join: masks keep the power of independent sounds, and direct sound passes whole") {
    const WaveMasks masks{120};
    for (double hz = 20; hz < 1000; hz *= 1.01) {
        const double low = masks.low(hz);
        const double high = masks.high(hz);
        CHECK(low * low + high * high == Approx(1).margin(1e-9));
    }
    CHECK(masks.low(masks.end_hz() * 1.001) == Approx(0).margin(1e-9));
    CHECK(masks.high(84) == 0);
    CHECK(masks.high(170) == 1);
    // A step of level at any ratio of direct and reverberant sound: the direct sound is not masked,
    // so that only the sum of squares counts.
    RandomStream random(5);
    std::vector<float> noise(8000);
    for (float& x : noise) x = random.uniform() - 0.5F;
    std::vector<float> high = noise;
    keep_high(masks, kRate_hz, high);
    CHECK(std::abs(db(octave_energy(high, 1000) / octave_energy(noise, 1000))) < 0.05);
    CHECK(db(octave_energy(high, 63) / octave_energy(noise, 63)) < -30);
}

TEST_CASE("wave_join: octaves of a measured box are those of the exact field") {
    MeasurementOptions options;
    options.frames = 16;
    const Scene scene = living_room(Simulation::kHighestWaves_hz);
    const auto measured = measure(scene, scene.sources, receivers(), options);
    REQUIRE(measured);
    CHECK(measured->waves_below_hz > 150);
    CHECK(measured->waves_below_hz < 200);
    CHECK(measured->warnings.empty());

    const double beta = admittance_of_absorption(0.1);
    const test::DampedBox box{kSize, {{{beta, beta}, {beta, beta}, {beta, beta}}}};
    std::vector<double> wave_numbers;
    constexpr double kStep_hz = 0.25;
    for (double hz = 40; hz < 180; hz += kStep_hz) {
        wave_numbers.push_back(2 * kPi * hz / kSpeed_m_s);
    }
    std::vector<Vec3> places;
    for (const Pose& pose : receivers()) places.push_back(pose.position);
    const auto truth =
        test::exact_box(box, kSource, places, wave_numbers, 2 * kPi * 600 / kSpeed_m_s);
    // Rays know no nodes.
    const auto rays = measure(living_room(0), scene.sources, receivers(), options);
    REQUIRE(rays);
    CHECK(db(squared_pressure(rays->response(0, 0).total(0)) /
             octave_energy(truth[0], 40, kStep_hz, 63)) > 8);

    const ImpulseResponses responses(*measured,
                                     {.sample_rate_hz = kRate_hz, .output = OutputFormat::foa});
    for (std::size_t r = 0; r < places.size(); ++r) {
        CAPTURE(r);
        const double exact_63 = octave_energy(truth[r], 40, kStep_hz, 63);
        const double exact_125 = octave_energy(truth[r], 40, kStep_hz, 125);
        const EnergyResponse& energy = measured->response(0, r);
        const auto channels = responses.response(0, r);
        CHECK(std::abs(db(octave_energy(channels[0], 63) / exact_63)) < 0.3);
        CHECK(std::abs(db(octave_energy(channels[0], 125) / exact_125)) < 1);
        // Octaves of energy responses have wider flanks.
        CHECK(std::abs(db(squared_pressure(energy.total(0)) / exact_63)) < 1);
        CHECK(std::abs(db(squared_pressure(energy.total(1)) / exact_125)) < 1);
    }
}

TEST_CASE("wave_join: without waves a measurement is that of rays, and so is an open room's") {
    MeasurementOptions options;
    options.frames = 4;
    const auto rays = measure(living_room(0), options);
    REQUIRE(rays);
    CHECK(rays->waves == nullptr);
    CHECK(rays->waves_below_hz == 0);
    Scene open = living_room(Simulation::kHighestWaves_hz);
    open.objects[0].triangles.resize(2);
    open.objects[0].triangle_materials.resize(2);
    const auto measured = measure(open, options);
    REQUIRE(measured);
    CHECK(measured->waves == nullptr);
    REQUIRE(measured->warnings.size() == 1);
    CHECK(measured->warnings[0].find("open") != std::string::npos);
}

TEST_CASE("wave_join: sources without modes are named, and leave the others theirs") {
    MeasurementOptions options;
    options.frames = 4;
    Scene scene = living_room(Simulation::kHighestWaves_hz);
    scene.sources[0].name = "inside";
    SECTION("directed") {
        scene.sources[0].directivity = Directivity::find("talker").value();
        const auto measured = measure(scene, options);
        REQUIRE(measured);
        CHECK(measured->waves_below_hz == 0);
        CHECK(measured->waves == nullptr);
        REQUIRE(measured->warnings.size() == 1);
        CHECK(measured->warnings[0] ==
              "waves: none of source \"inside\", because it has a directivity");
    }
    SECTION("outside the room") {
        const auto alone = measure(scene, options);
        scene.sources.push_back(scene.sources[0]);
        scene.sources[1].name = "outside";
        scene.sources[1].position = {-3, 1, 1};
        const auto measured = measure(scene, options);
        REQUIRE(alone);
        REQUIRE(measured);
        CHECK(measured->waves_below_hz == alone->waves_below_hz);
        REQUIRE(measured->waves);
        CHECK(measured->waves->pairs[0]);
        CHECK_FALSE(measured->waves->pairs[1]);
        CHECK(std::count_if(measured->warnings.begin(), measured->warnings.end(),
                            [](const std::string& w) {
                                return w.starts_with("waves: none of source \"outside\"");
                            }) == 1);
        CHECK(squared_pressure(measured->response(0, 0).total(0)) ==
              Approx(squared_pressure(alone->response(0, 0).total(0))).epsilon(0.02));
    }
    SECTION("a receiver outside the room") {
        scene.listener.pose.position = {-3, 1, 1};
        const auto measured = measure(scene, options);
        REQUIRE(measured);
        CHECK(measured->waves_below_hz == 0);
        CHECK(std::count(measured->warnings.begin(), measured->warnings.end(),
                         "waves: none, because no receiver is in the air of a source's room") == 1);
    }
    SECTION("flat or large rooms") {
        const Vec3 size = GENERATE(Vec3(60, 60, 0.05F), Vec3(2000, 2000, 900));
        scene.objects[0] = test::box(size);
        scene.sources[0].position = size * 0.3F;
        const WaveJoin join(scene);
        REQUIRE(join.warnings().size() == 1);
        CHECK(join.warnings()[0].find("too flat or too large") != std::string::npos);
    }
}

TEST_CASE("wave_join: a receiver at the source is as loud as one at the nearest distance") {
    MeasurementOptions options;
    options.frames = 4;
    const Scene scene = living_room(Simulation::kHighestWaves_hz);
    std::vector<Pose> near(3);
    near[0].position = kSource;
    near[1].position = kSource + Vec3(0.01F, 0, 0);
    near[2].position = kSource + Vec3(0.1F, 0, 0);
    const auto measured = measure(scene, scene.sources, near, options);
    REQUIRE(measured);
    REQUIRE(measured->waves_below_hz > 0);
    for (std::size_t band = 0; band < 3; ++band) {
        const auto level = [&](std::size_t r) {
            return db(squared_pressure(measured->response(0, r).total(band)));
        };
        CAPTURE(band);
        CHECK(std::abs(level(0) - level(2)) < 1);
        CHECK(std::abs(level(1) - level(2)) < 1);
    }
}

TEST_CASE("wave_join: the state of a scene contains the limit of the modes") {
    const std::string state = scene_state(living_room(120), false);
    CHECK(state != scene_state(living_room(0), false));
    CHECK(scene_from_state(scene_state(living_room(120), true)).simulation.waves_hz == 120);
}

TEST_CASE("wave_join: the same bytes with 1 and 3 threads, and the same decay in both parts") {
    MeasurementOptions options;
    options.frames = 8;
    std::vector<std::vector<float>> first;
    for (const int threads : {1, 3}) {
        Scene scene = living_room(Simulation::kHighestWaves_hz);
        scene.simulation.threads = threads;
        const auto measured = measure(scene, options);
        REQUIRE(measured);
        const ImpulseResponses responses(*measured,
                                         {.sample_rate_hz = kRate_hz, .output = OutputFormat::foa});
        const auto channels = responses.response(0, 0);
        if (first.empty()) first = channels;
        CHECK(channels == first);
        // The decays of the modes: oblique ones as Eyring's, axial ones up to 1.6 times as long.
        const auto& t20 = measured->parameters[0].octave(AcousticParameter::t20, 0).value;
        REQUIRE(t20);
        CHECK(*t20 > 0.9);
        CHECK(*t20 < 1.7);
    }
}
