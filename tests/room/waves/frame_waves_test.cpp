#include "apps/room/waves/frame_waves.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <complex>
#include <numbers>
#include <stop_token>
#include <thread>
#include <vector>

#include "aula/auralizer.h"
#include "tests/support/rooms.h"

namespace frame_waves_test {

using namespace aula;

namespace {

constexpr double kRate_hz = 8000;
const Vec3 kSource(1.2F, 1.1F, 1.5F);
const Vec3 kReceiver(4.4F, 2.3F, 1.1F);
const std::vector<Vec3> kSources{kSource};

/// A room of 6 x 4 x 3 m; object 1 divides it at x = 3 m, and is movable.
Scene divided_room() {
    Scene scene = test::grey_room(test::box({6, 4, 3}), 0.1F, 0.3F, kSource, kReceiver);
    scene.simulation = {};
    scene.simulation.waves_hz = 150;
    scene.simulation.threads = 1;
    scene.simulation.rays = 200;
    Object wall;
    wall.name = "wall";
    wall.vertices = {{3, 0, 0}, {3, 4, 0}, {3, 4, 3}, {3, 0, 3}};
    wall.triangles = {{0, 1, 2}, {0, 2, 3}};
    wall.triangle_materials = {0, 0};
    wall.movable = true;
    scene.objects.push_back(wall);
    return scene;
}

/// The wall far above the room, or in it.
std::vector<RigidTransform> wall_at(float height_m) {
    std::vector<RigidTransform> transforms(2);
    transforms[1].translation = {0, 0, height_m};
    return transforms;
}

/// The level of the modes at the receiver from 40 to 100 Hz in dB; empty without modes.
std::optional<double> level_db(const FrameWaves& waves) {
    const auto pair = waves.pair(kSource, kReceiver, EnergyResponse::silent(TimeBins(1)));
    if (!pair) return {};
    double sum = 0;
    const WaveTransform transform(4, 500);
    const auto first = static_cast<std::size_t>(40 / transform.step_hz());
    const auto end = static_cast<std::size_t>(100 / transform.step_hz());
    const WaveSpectra field = pair->field(transform, end);
    for (std::size_t i = first; i < end; ++i) sum += std::norm(field[0][i]);
    return 10 * std::log10(sum / static_cast<double>(end - first));
}

FrameWaves waves_of(const Scene& scene, WavesReady ready = WavesReady::at_once) {
    return {scene, ready};
}

}  // namespace

TEST_CASE("frame_waves: modes follow an object that moves within 0.3 s") {
    FrameWaves waves = waves_of(divided_room());
    CHECK_FALSE(level_db(waves));
    waves.begin_frame(0, kSources, wall_at(20));
    const auto open_db = level_db(waves);
    REQUIRE(open_db);
    // The receiver is then in another room than the source.
    waves.begin_frame(0.1, kSources, wall_at(0));
    CHECK(level_db(waves) == open_db);
    waves.begin_frame(0.3, kSources, wall_at(0));
    CHECK_FALSE(level_db(waves));
    // The search begins from other modes.
    waves.begin_frame(0.6, kSources, wall_at(20));
    CHECK(level_db(waves).value() == Approx(*open_db).margin(0.02));
}

TEST_CASE("frame_waves: modes follow materials") {
    FrameWaves waves = waves_of(divided_room());
    waves.begin_frame(0, kSources, wall_at(20));
    const auto hard_db = level_db(waves);
    Material soft;
    soft.absorption = Bands::filled(0.5F);
    SECTION("of the scene") { waves.change_material(0, soft); }
    SECTION("of an object") {
        waves.set_object_material(0, Material{});
        waves.set_object_material(0, soft);
    }
    waves.begin_frame(1, kSources, wall_at(20));
    Scene scene = divided_room();
    scene.materials[0].absorption = soft.absorption;
    FrameWaves expected = waves_of(scene);
    expected.begin_frame(0, kSources, wall_at(20));
    REQUIRE(level_db(waves));
    // The search begins from other modes.
    CHECK(*level_db(waves) == Approx(*level_db(expected)).margin(0.05));
    CHECK(*level_db(waves) < *hard_db - 3);
}

TEST_CASE("frame_waves: modes follow a source to another room") {
    FrameWaves waves = waves_of(divided_room());
    const auto has_modes = [&](const Vec3& source) {
        return waves.pair(source, kReceiver, EnergyResponse::silent(TimeBins(1))).has_value();
    };
    waves.begin_frame(0, kSources, wall_at(0));
    CHECK_FALSE(has_modes(kSource));
    const std::vector<Vec3> moved{{4.1F, 1.1F, 1.5F}};
    waves.begin_frame(1, moved, wall_at(0));
    CHECK_FALSE(has_modes(moved[0]));
    waves.begin_frame(2, moved, wall_at(0));
    CHECK(has_modes(moved[0]));
    // With the modes of both rooms, no air connects them.
    const std::vector<Vec3> both{moved[0], kSource};
    waves.begin_frame(4, both, wall_at(0));
    CHECK(has_modes(moved[0]));
    CHECK_FALSE(has_modes(kSource));
}

TEST_CASE("frame_waves: in real time the modes are those of a file, once they are ready") {
    const Scene scene = divided_room();
    FrameWaves at_once = waves_of(scene);
    at_once.begin_frame(0, kSources, wall_at(20));
    FrameWaves later = waves_of(scene, WavesReady::later);
    later.begin_frame(0, kSources, wall_at(20));
    CHECK_FALSE(level_db(later));
    for (int frame = 1; frame < 3000 && !level_db(later); ++frame) {
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
        later.begin_frame(frame / 30.0, kSources, wall_at(20));
    }
    CHECK(level_db(later) == level_db(at_once));
}

TEST_CASE("frame_waves: a search that is no longer wanted ends early") {
    Scene scene = divided_room();
    scene.objects.resize(1);
    scene.simulation.waves_hz = Simulation::kHighestWaves_hz;
    std::stop_source stop;
    stop.request_stop();
    const WaveJoin stopped(scene, nullptr, stop.get_token());
    CHECK(stopped.rooms().empty());
    CHECK(WaveJoin(scene).rooms().size() == 1);
}

TEST_CASE("frame_waves: without waves, and at a place in no room, rays are alone") {
    Scene scene = divided_room();
    SECTION("without waves") {
        scene.simulation.waves_hz = 0;
        FrameWaves waves = waves_of(scene);
        waves.begin_frame(0, kSources, wall_at(20));
        waves.change_material(0, Material{});
        CHECK_FALSE(level_db(waves));
    }
    SECTION("outside") {
        FrameWaves waves = waves_of(scene);
        waves.begin_frame(0, kSources, wall_at(20));
        CHECK_FALSE(waves.pair({-3, 1, 1}, kReceiver, EnergyResponse::silent(TimeBins(1))));
    }
}

TEST_CASE("frame_waves: in real time modes come in, and follow a wall, without a click") {
    constexpr int kBlock = 64;
    constexpr std::size_t kSecond = static_cast<std::size_t>(kRate_hz);
    constexpr double kTone_hz = 30;
    // The level of the last half second.
    const auto level_db = [](const std::vector<float>& samples) {
        double sum = 0;
        for (std::size_t i = samples.size() - kSecond / 2; i < samples.size(); ++i)
            sum += double{samples[i]} * double{samples[i]};
        return 10 * std::log10(sum);
    };
    // The samples until a condition holds for them, and of a second after a wall has come in.
    const auto rendered = [&](RenderClock clock, float waves_hz, auto&& ends) {
        Scene scene = divided_room();
        scene.simulation.waves_hz = waves_hz;
        AuralizerOptions options;
        options.sample_rate_hz = kRate_hz;
        options.output = OutputFormat::mono;
        options.clock = clock;
        Auralizer auralizer(scene, options);
        auralizer.set_transform(1, wall_at(20)[1]);
        std::vector<float> output;
        const auto start = std::chrono::steady_clock::now();
        std::optional<std::size_t> end;
        while (!end || output.size() < *end) {
            std::array<float, kBlock> input{};
            for (std::size_t n = 0; n < input.size(); ++n)
                input[n] =
                    static_cast<float>(std::sin(2 * std::numbers::pi * kTone_hz *
                                                static_cast<double>(output.size() + n) / kRate_hz));
            output.resize(output.size() + kBlock);
            const std::array<SourceSignal, 1> inputs{{{auralizer.sources()[0], input.data()}}};
            const std::array<float*, 1> outputs{output.data() + output.size() - kBlock};
            auralizer.render(inputs, outputs, kBlock);
            if (clock == RenderClock::real_time)
                std::this_thread::sleep_until(
                    start + std::chrono::milliseconds(1000 * output.size() / kSecond));
            if (end || output.size() < 2 * kSecond || !ends(output)) continue;
            auralizer.set_transform(1, {});
            end = output.size() + kSecond;
        }
        return output;
    };
    const auto at_once = [](const std::vector<float>&) { return true; };
    const auto before_wall = [](std::vector<float> samples) {
        samples.resize(samples.size() - kSecond);
        return samples;
    };
    const double modes_db = level_db(before_wall(rendered(RenderClock::exact, 150, at_once)));
    const double rays_db = level_db(before_wall(rendered(RenderClock::exact, 0, at_once)));
    CHECK(std::abs(modes_db - rays_db) > 2);
    const auto live = rendered(RenderClock::real_time, 150, [&](const auto& samples) {
        return std::abs(level_db(samples) - modes_db) < 0.3 || samples.size() > 60 * kSecond;
    });
    CHECK(level_db(before_wall(live)) == Approx(modes_db).margin(0.3));
    // The largest third difference, after the beginning with the first frame: of the tone it is
    // 1e-4 of the peak, at a step the step.
    const auto sharpest = [](const std::vector<float>& x) {
        float largest = 0;
        float peak = 0;
        const auto start =
            std::find_if(x.begin(), x.end(), [](float sample) { return sample != 0; });
        for (auto i = static_cast<std::size_t>(start - x.begin()) + 1; i + 3 < x.size(); ++i) {
            largest = std::max(largest, std::abs(x[i + 3] - 3 * x[i + 2] + 3 * x[i + 1] - x[i]));
            peak = std::max(peak, std::abs(x[i]));
        }
        return double{largest / peak};
    };
    CHECK(sharpest(live) < 0.01);
    // Companion: the same sound that is cut at its largest sample.
    std::vector<float> cut = live;
    std::fill(std::max_element(cut.begin(), cut.end()), cut.end(), 0.0F);
    CHECK(sharpest(cut) > 0.05);
}

TEST_CASE("frame_waves: a rendering has the modes of a measurement, and a seed the same bytes") {
    Scene scene = divided_room();
    scene.objects.pop_back();
    const auto impulse_response = [&](float waves_hz) {
        scene.simulation.waves_hz = waves_hz;
        AuralizerOptions options;
        options.sample_rate_hz = kRate_hz;
        options.output = OutputFormat::foa;
        options.clock = RenderClock::exact;
        Auralizer auralizer(scene, options);
        std::vector<float> input(4000);
        std::array<std::vector<float>, 4> output;
        std::vector<float*> outputs;
        for (auto& channel : output) {
            channel.resize(input.size());
            outputs.push_back(channel.data());
        }
        const std::array<SourceSignal, 1> inputs{{{auralizer.sources()[0], input.data()}}};
        auralizer.render(inputs, outputs, 4000);
        return auralizer.impulse_response(auralizer.sources()[0]);
    };
    const auto modes = impulse_response(150);
    const auto rays = impulse_response(0);
    CHECK(modes == impulse_response(150));
    CHECK(modes[0] != rays[0]);
    const auto power = [](const std::vector<float>& signal, double from_hz, double to_hz) {
        double sum = 0;
        int count = 0;
        for (double hz = from_hz; hz < to_hz; hz += 2, ++count) {
            std::complex<double> at = 0;
            for (std::size_t n = 0; n < signal.size(); ++n)
                at += double{signal[n]} * std::polar(1.0, -2 * std::numbers::pi * hz / kRate_hz *
                                                              static_cast<double>(n));
            sum += std::norm(at);
        }
        return 10 * std::log10(sum / count);
    };
    FrameWaves waves = waves_of(divided_room());
    waves.begin_frame(0, kSources, wall_at(20));
    CHECK(power(modes[0], 40, 100) == Approx(*level_db(waves)).margin(0.5));
    CHECK(power(modes[0], 500, 1000) == Approx(power(rays[0], 500, 1000)).margin(0.2));
}

}  // namespace frame_waves_test
