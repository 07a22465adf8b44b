#include "apps/room/waves/wave_join.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <numbers>
#include <string>
#include <vector>

#include "apps/room/edit/scene_state.h"
#include "apps/room/waves/wave_synthesis.h"
#include "audio/dsp/fft.h"
#include "aula/engine/impulse_response.h"
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

TEST_CASE("wave_join: masks keep the power of independent sounds") {
    const WaveMasks masks{120};
    for (double hz = 20; hz < 1000; hz *= 1.01) {
        const double low = masks.low(hz);
        const double high = masks.high(hz);
        CHECK(low * low + high * high == Approx(1).margin(1e-9));
    }
    CHECK(masks.low(masks.end_hz() * 1.001) == Approx(0).margin(1e-9));
    CHECK(masks.high(84) == 0);
    CHECK(masks.high(170) == 1);
}

TEST_CASE("wave_join: the reverberation above a crossover has the power of the mask") {
    const auto carriers = make_noise_carriers(kRate_hz, 1);
    EnergyResponse energy = EnergyResponse::silent(TimeBins(2));
    for (Bands& bin : energy.energy) bin = Bands::filled(1e-4F);
    ImpulseResponseBuilder builder(carriers, Medium{}, 2, "a", 1);
    ImpulseResponse whole;
    ImpulseResponse above;
    builder.build(energy, whole);
    constexpr double kCrossover_hz = 177;
    builder.build(energy, above, kCrossover_hz);
    for (std::size_t c = 0; c < 4; ++c) {
        CHECK(db(octave_energy(above.channels[c], 1000) / octave_energy(whole.channels[c], 1000)) ==
              Approx(0).margin(0.05));
        // Half of the octave 125 Hz is masked, and of 250 Hz, which begins at the crossover,
        // little.
        double wanted = 0;
        constexpr int kPoints = 100;
        for (int i = 0; i < kPoints; ++i) {
            const double hz = 250 * (1 + (i + 0.5) / kPoints) / std::numbers::sqrt2;
            const double amplitude = WaveMasks{kCrossover_hz}.high(hz);
            wanted += amplitude * amplitude / kPoints;
        }
        CHECK(db(octave_energy(above.channels[c], 250) / octave_energy(whole.channels[c], 250)) ==
              Approx(db(wanted)).margin(0.3));
        CHECK(db(octave_energy(above.channels[c], 63) / octave_energy(whole.channels[c], 63)) <
              -20);
    }
}

TEST_CASE("wave_join: below the crossover the field takes the place of the paths that are played") {
    // A field without poles is silent.
    const WaveMasks masks{120};
    WaveResponse field;
    field.from_source = {2, 1, 0};
    field.highest_wave_number = 2 * kPi * 180 / kSpeed_m_s;
    const SoundPath::Kind kind =
        GENERATE(SoundPath::Kind::direct, SoundPath::Kind::image, SoundPath::Kind::through_walls);
    const bool seen = kind == SoundPath::Kind::direct;
    const double distance_m = std::sqrt(5.0);
    SoundPath direct;
    direct.kind = kind;
    direct.length_m = static_cast<float>(distance_m);
    direct.direction = -field.from_source / direct.length_m;
    direct.energy = Bands::filled(static_cast<float>(1 / (4 * kPi * 5)));
    EnergyResponse rays = EnergyResponse::silent(TimeBins(0.5));
    rays.paths.push_back(direct);
    const double delay_s = distance_m / kSpeed_m_s;
    ImpulseResponseBuilder builder(make_noise_carriers(kRate_hz, 1), Medium{}, 0.5, "a", 1);
    ImpulseResponse response;
    WaveSynthesis(kRate_hz, builder.length_samples())
        .build(
            builder, rays,
            PairWaves(field, seen ? std::optional(direct) : std::nullopt, masks, kSpeed_m_s),
            [&](const SoundPath& path) { return double{path.length_m} / kSpeed_m_s; }, response);
    // With the path itself.
    std::vector<float> sum = response.channels[0];
    const std::size_t size = 8192;
    sum.resize(size);
    RealFft fft(size);
    std::vector<std::complex<float>> spectrum(fft.bins());
    fft.forward(sum.data(), spectrum.data());
    for (const double hz : {40.0, 60.0, 400.0}) {
        const double step_hz = kRate_hz / size;
        const auto k = static_cast<std::size_t>(hz / step_hz);
        const std::complex<double> path =
            std::polar(1 / distance_m, -2 * kPi * static_cast<double>(k) * step_hz * delay_s);
        const double level = db(std::norm(std::complex<double>(spectrum[k]) + path) * 5);
        CAPTURE(seen, hz, level);
        // Modes have no sound through walls. The near field that they lack remains of the direct
        // sound.
        if (hz > 300 || kind == SoundPath::Kind::through_walls)
            CHECK(std::abs(level) < 0.1);
        else
            CHECK(level < (seen ? -20 : -30));
    }
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
    REQUIRE(measured->without_waves.size() == 1);
    CHECK(measured->without_waves[0].find("open") != std::string::npos);
}

TEST_CASE("wave_join: sources without modes are named, and leave the others theirs") {
    MeasurementOptions options;
    options.frames = 4;
    Scene scene = living_room(Simulation::kHighestWaves_hz);
    scene.sources[0].name = "inside";
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
        CHECK(std::count_if(measured->without_waves.begin(), measured->without_waves.end(),
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
        CHECK(std::count(measured->without_waves.begin(), measured->without_waves.end(),
                         "waves: none at 1 of 1 pairs of a source and a receiver, which are not in "
                         "one room; rays "
                         "are alone there") == 1);
    }
    SECTION("flat or large rooms, a hall and one that absorbs all") {
        const Vec3 size =
            GENERATE(Vec3(60, 60, 0.05F), Vec3(2000, 2000, 900), Vec3(40, 30, 15), Vec3(5, 4, 3));
        if (size.x == 5) scene.materials[0].absorption = Bands::filled(1);
        scene.objects[0] = test::box(size);
        scene.sources[0].position = size * 0.3F;
        const WaveJoin join(scene);
        REQUIRE(join.warnings().size() == 1);
        CAPTURE(join.warnings()[0], size.x);
        CHECK(join.warnings()[0].find("the modes that can be computed end below 45 Hz") !=
              std::string::npos);
    }
}

TEST_CASE(
    "wave_join: the direct sound of a directed source has its directivity, the rest its power") {
    MeasurementOptions options;
    options.frames = 4;
    Scene scene = living_room(Simulation::kHighestWaves_hz);
    const auto response_of = [&](const char* directivity, float yaw_rad) {
        scene.sources[0].directivity = Directivity::find(directivity).value();
        scene.sources[0].yaw_rad = yaw_rad;
        const auto measured = measure(scene, options);
        REQUIRE(measured);
        REQUIRE(measured->waves);
        const ImpulseResponses responses(*measured,
                                         {.sample_rate_hz = kRate_hz, .output = OutputFormat::foa});
        return std::pair(measured->responses[0], responses.response(0, 0)[0]);
    };
    const auto [omni, omni_signal] = response_of("omni", 0);
    const auto [front, front_signal] = response_of("cardioid", 0.5F);
    // Only the direct sound differs.
    const auto late = [](const EnergyResponse& energy) {
        double sum = 0;
        for (std::size_t i = 0; i < energy.bins.count(); ++i)
            if (energy.bins.begin_s(i) > 0.15) sum += double{energy.energy[i][0]};
        return sum;
    };
    CHECK(std::abs(db(late(front) / late(omni))) < 0.3);
    CHECK(front.total(0) != omni.total(0));
    const std::vector<float> omni_late(omni_signal.begin() + 1600, omni_signal.end());
    const std::vector<float> front_late(front_signal.begin() + 1600, front_signal.end());
    CHECK(std::abs(db(octave_energy(front_late, 63) / octave_energy(omni_late, 63))) < 0.3);
}

TEST_CASE("wave_join: impulse responses have the energies of reports, also with steep absorption") {
    Scene scene = living_room(Simulation::kHighestWaves_hz);
    const bool falls = GENERATE(true, false);
    scene.materials[0].absorption =
        falls ? Bands{{0.55F, 0.3F, 0.1F, 0.05F, 0.05F, 0.05F, 0.05F, 0.05F}}
              : Bands{{0.03F, 0.05F, 0.3F, 0.8F, 0.8F, 0.8F, 0.8F, 0.8F}};
    MeasurementOptions options;
    options.frames = 16;
    const auto measured = measure(scene, scene.sources, receivers(), options);
    REQUIRE(measured);
    REQUIRE(measured->waves);
    CHECK(measured->waves_below_hz > 100);
    const ImpulseResponses responses(*measured,
                                     {.sample_rate_hz = kRate_hz, .output = OutputFormat::foa});
    for (std::size_t r = 0; r < receivers().size(); ++r) {
        const std::vector<float> w = responses.response(0, r)[0];
        CAPTURE(falls, r);
        // Octaves of energy responses have wider flanks.
        CHECK(std::abs(db(octave_energy(w, 63) /
                          squared_pressure(measured->response(0, r).total(0)))) < 1.5);
    }
}

TEST_CASE("wave_join: each room has the modes that its size allows") {
    Scene scene = living_room(Simulation::kHighestWaves_hz);
    const WaveJoin alone(scene);
    REQUIRE(alone.rooms().size() == 1);
    // A hall far away, whose modes end below all octaves, and an equal room.
    for (const Vec3& size : {Vec3(30, 20, 12), kSize}) {
        const Vec3 corner(100 * static_cast<float>(scene.objects.size()), 0, 0);
        scene.objects.push_back(test::box(size, 0, corner));
        scene.objects.back().name = std::to_string(scene.objects.size());
        Source& source = scene.sources.emplace_back(scene.sources[0]);
        source.name = scene.objects.back().name;
        source.position += corner;
    }
    const WaveJoin join(scene);
    REQUIRE(join.rooms().size() == 2);
    REQUIRE(join.warnings().size() == 1);
    for (const RoomWaves& room : join.rooms())
        CHECK(room.highest_hz() == Approx(alone.rooms()[0].highest_hz()).epsilon(0.01));
}

TEST_CASE("wave_join: behind a wall that transmits, a slit does not take the bass away") {
    Scene scene = living_room(Simulation::kHighestWaves_hz);
    scene.sources[0].position = {1, 2, 1.5F};
    scene.listener.pose.position = {4, 1, 1};
    Material thin;
    thin.name = "thin";
    thin.absorption = Bands::filled(0.6F);
    thin.sound_reduction_db = Bands{{6, 8, 12, 16, 20, 24, 28, 32}};
    scene.materials.push_back(thin);
    // To 0.1 m below the ceiling.
    Object wall;
    wall.name = "wall";
    wall.vertices = {{2.5F, 0, 0}, {2.5F, 4, 0}, {2.5F, 4, 2.9F}, {2.5F, 0, 2.9F}};
    wall.triangles = {{0, 1, 2}, {0, 2, 3}};
    wall.triangle_materials = {1, 1};
    scene.objects.push_back(wall);
    MeasurementOptions options;
    options.frames = 16;
    const auto measured = measure(scene, options);
    scene.simulation.waves_hz = 0;
    const auto rays = measure(scene, options);
    REQUIRE(measured);
    REQUIRE(rays);
    for (const std::size_t band : {0U, 1U})
        CHECK(db(squared_pressure(measured->response(0, 0).total(band)) /
                 squared_pressure(rays->response(0, 0).total(band))) > -7);
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

TEST_CASE("wave_join: responses that end before the room has decayed are cut, not wrapped") {
    // Without losses the level stays; in a longer response the beginning is the same.
    const float absorption = GENERATE(0.0F, 0.05F);
    MeasurementOptions options;
    options.frames = 4;
    std::vector<EnergyResponse> energies;
    std::vector<std::vector<float>> signals;
    for (const float length_s : {0.3F, 2.0F}) {
        Scene scene = living_room(Simulation::kHighestWaves_hz);
        scene.materials[0].absorption = Bands::filled(absorption);
        scene.simulation.ir_length_s = length_s;
        const auto measured = measure(scene, options);
        REQUIRE(measured);
        REQUIRE(measured->waves);
        energies.push_back(measured->responses[0]);
        const ImpulseResponses responses(*measured,
                                         {.sample_rate_hz = kRate_hz, .output = OutputFormat::foa});
        signals.push_back(responses.response(0, 0)[0]);
    }
    CAPTURE(absorption);
    const auto energy_until = [](const EnergyResponse& energy, double begin_s, double end_s) {
        double sum = 0;
        for (std::size_t i = 0; i < energy.bins.count(); ++i)
            if (energy.bins.begin_s(i) >= begin_s && energy.bins.end_s(i) <= end_s)
                sum += double{energy.energy[i][0]};
        return sum;
    };
    CHECK(std::abs(db(energy_until(energies[0], 0, 0.25) / energy_until(energies[1], 0, 0.25))) <
          0.5);
    std::vector<float> longer(signals[1].begin(),
                              signals[1].begin() + static_cast<std::ptrdiff_t>(signals[0].size()));
    CHECK(std::abs(db(octave_energy(signals[0], 63) / octave_energy(longer, 63))) < 0.5);
    if (absorption == 0) {
        const double early = energy_until(energies[1], 0.2, 1);
        const double late = energy_until(energies[1], 1, 1.8);
        CHECK(std::abs(db(early / late)) < 1);
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
