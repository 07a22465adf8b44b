#include "aula/auralizer.h"

#include <sched.h>
#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <functional>
#include <limits>
#include <numbers>
#include <numeric>
#include <set>

#include "aula/audio/realtime.h"
#include "aula/exception.h"
#include "tests/room/auralizer/auralizer_rendering.h"
#include "tests/support/test_scenes.h"
#include "tests/support/tone.h"
#include "tests/support/wait.h"

namespace {

using namespace aula;
using namespace aula::test;

std::set<std::string> thread_ids() {
    std::set<std::string> ids;
    for (const auto& entry : std::filesystem::directory_iterator("/proc/self/task"))
        ids.insert(entry.path().filename());
    return ids;
}

}  // namespace

TEST_CASE("A tone has no clicks while everything changes") {
    const std::string what = GENERATE("nothing", "add", "remove", "replace", "transform",
                                      "material", "gain", "pause", "listener");
    Scene scene = room_with_panel();
    scene.sources = test::small_room().sources;
    AuralizerOptions options = mono();
    // There is no other slot for the source that replaces the first.
    if (what == "replace") options.max_sources = 1;
    Auralizer auralizer(scene, options);
    const SourceId source = auralizer.sources()[0];
    if (what == "add") auralizer.add_source({.position = {1, 3, 2}}, 20011);
    if (what == "remove" || what == "replace") auralizer.remove_source(source, 24001);
    if (what == "replace") auralizer.add_source({.position = {1, 3, 2}}, 24001);
    if (what == "material") auralizer.set_material(0, "curtain", 20011);
    if (what == "gain") auralizer.set_gain(source, -12, 20011);
    if (what == "transform") {
        for (int k = 0; k < 30; ++k)
            auralizer.set_transform(1,
                                    RigidTransform(at(0.02F * static_cast<float>(k), 0, 0,
                                                      0.05F * static_cast<float>(k))),
                                    10000 + 1000 * k);
    }
    if (what == "listener") {
        for (int k = 0; k < 30; ++k)
            auralizer.set_listener(at(3.7F - 0.04F * static_cast<float>(k), 2.9F, 1.2F),
                                   10000 + 1000 * k);
    }
    const auto output = rendered(auralizer, 96000, {490}, tone_at, [&](std::int64_t position) {
        if (what == "pause" && position == 24500) auralizer.pause();
        if (what == "pause" && position == 30870) auralizer.resume();
    });
    const double share = share_off_tone(output);
    INFO(what << ", off the tone: " << 10 * std::log10(share) << " dB");
    // The requirement is -60 dB; an abrupt begin is at -36 dB.
    CHECK(share < 1e-6);
    // Companion: a signal that is cut off in the middle is detected.
    auto cut = output;
    std::fill(cut.begin() + 24000, cut.end(), 0.0F);
    CHECK(share_off_tone(cut) > 1e-5);
}

TEST_CASE("A removed source rings out, and its slot is reused") {
    Scene scene = room_with_panel();
    AuralizerOptions options = mono();
    options.max_sources = 1;
    Auralizer auralizer(scene, options);
    const SourceId first = auralizer.add_source({.position = {1, 1, 1}}, 0);
    CHECK_THROWS_AS(auralizer.add_source({}), InputError);
    auralizer.remove_source(first, 4800);
    const auto output = rendered(auralizer, 48000, {256}, noise_at);
    const auto energy = [&](std::int64_t from, std::int64_t to) {
        return std::inner_product(output.begin() + from, output.begin() + to, output.begin() + from,
                                  0.0F);
    };
    // Its fade lasts 960 samples, the response 14400.
    CHECK(energy(6100, 7000) > 0);
    CHECK(energy(24000, 48000) == 0);
    CHECK(auralizer.sources().empty());
    const SourceId second = auralizer.add_source({.position = {1, 3, 1}});
    CHECK(second.number != first.number);
    CHECK(auralizer.sources() == std::vector<SourceId>{second});
    const auto again = rendered(auralizer, 9600, {256}, noise_at);
    CHECK(std::any_of(again.begin(), again.end(), [](float x) { return std::abs(x) > 0.001F; }));
}

TEST_CASE("A room without sources is silent, and 64 sources are audible") {
    Scene scene = room_with_panel();
    scene.simulation.estimator =
        GENERATE(Estimator::patch, Estimator::pt, Estimator::dpc, Estimator::dpc_published);
    scene.simulation.rays = 20;
    AuralizerOptions options = mono();
    options.max_sources = 64;
    Auralizer auralizer(scene, options);
    const auto silent = rendered(auralizer, 4800, {256}, noise_at);
    CHECK(std::all_of(silent.begin(), silent.end(), [](float x) { return x == 0; }));
    for (int s = 0; s < 64; ++s)
        auralizer.add_source({.position = {0.5F + 0.06F * static_cast<float>(s), 1, 1}});
    CHECK_THROWS_AS(auralizer.add_source({}), InputError);
    const auto output = rendered(auralizer, 9600, {256}, noise_at);
    CHECK(std::any_of(output.begin(), output.end(), [](float x) { return std::abs(x) > 0.01F; }));
    CHECK(std::all_of(output.begin(), output.end(), [](float x) { return std::isfinite(x); }));
    for (const SourceId source : auralizer.sources())
        if (source.number % 2 == 0) auralizer.remove_source(source);
    const auto less = rendered(auralizer, 9600, {256}, noise_at);
    CHECK(std::all_of(less.begin(), less.end(), [](float x) { return std::isfinite(x); }));
    CHECK(auralizer.sources().size() == 32);
}

TEST_CASE("Input samples that are not finite, or beyond 1e6, are silence and counted") {
    const RenderClock clock = GENERATE(RenderClock::exact, RenderClock::real_time);
    Scene scene = room_with_panel();
    scene.simulation.rays = 20;
    Auralizer auralizer(scene, mono(clock));
    const SourceId source = auralizer.add_source({.position = {1, 1, 1}}, 0);
    std::vector<float> input(9600);
    for (std::size_t n = 0; n < input.size(); ++n) input[n] = noise_at(static_cast<int>(n));
    // Among them one in the fade-out of the source.
    const std::vector<std::pair<std::size_t, float>> bad{
        {10, 1e38F}, {11, -2e6F}, {300, std::nanf("")}, {9400, -INFINITY}};
    for (const auto& [at, value] : bad) input[at] = value;
    std::vector<float> output(input.size());
    const auto render = [&](std::size_t first, std::size_t samples) {
        const SourceSignal signal{source, input.data() + first};
        float* const outputs[] = {output.data() + first};
        auralizer.render({&signal, 1}, outputs, static_cast<int>(samples));
    };
    if (clock == RenderClock::real_time)
        REQUIRE(eventually([&] { return auralizer.status().frames > 1; }));
    render(0, 9200);
    auralizer.remove_source(source);
    render(9200, 400);
    for (const float x : output) REQUIRE(std::abs(x) < 100);
    CHECK(std::any_of(output.begin(), output.end(), [](float x) { return x != 0; }));
    CHECK(auralizer.status().muted_samples == static_cast<std::int64_t>(bad.size()));
}

TEST_CASE("Sound beyond 1e6 is silence and counted, and after a lower gain there is sound again") {
    Scene scene = room_with_panel();
    scene.simulation.rays = 20;
    Auralizer auralizer(scene, mono());
    const SourceId source = auralizer.add_source({.position = {1, 1, 1}, .gain_db = 200}, 0);
    const auto loud = rendered(auralizer, 4800, {256}, noise_at);
    for (const float x : loud) REQUIRE(std::abs(x) <= 1e6F);
    CHECK(auralizer.status().muted_samples > 2400);
    auralizer.set_gain(source, 0);
    rendered(auralizer, 24000, {256}, noise_at);
    const std::int64_t muted = auralizer.status().muted_samples;
    const auto after = rendered(auralizer, 4800, {256}, noise_at);
    CHECK(auralizer.status().muted_samples == muted);
    CHECK(std::any_of(after.begin(), after.end(), [](float x) { return std::abs(x) > 0.001F; }));
}

TEST_CASE("The output for an impulse is the impulse response of the source") {
    Scene scene = room_with_panel();
    const OutputFormat output =
        GENERATE(OutputFormat::mono, OutputFormat::binaural, OutputFormat::foa);
    AuralizerOptions options = mono();
    options.output = output;
    Auralizer auralizer(scene, options);
    const SourceId source = auralizer.add_source({.position = {1, 1, 1}, .gain_db = -6}, 0);
    CHECK(auralizer.impulse_response(source).empty());
    // One frame only, so that it applies to the whole output.
    const auto samples =
        rendered(auralizer, 1536, {256}, [](std::int64_t n) { return n == 0 ? 1.0F : 0.0F; });
    const auto response = auralizer.impulse_response(source);
    REQUIRE(response.size() == auralizer.output_channels());
    double largest = 0;
    double worst = 0;
    for (std::size_t c = 0; c < response.size(); ++c) {
        for (std::size_t n = 0; n < 1280; ++n) {
            largest = std::max(largest, std::abs(static_cast<double>(response[c][n])));
            worst = std::max(
                worst, std::abs(static_cast<double>(response[c][n] - samples[c * 1536 + 256 + n])));
        }
    }
    REQUIRE(largest > 0.01);
    // Rounding: transforms and filters of single precision, some hundred operations of 6e-8.
    CHECK(worst < 2e-5 * largest);
    CHECK(auralizer.impulse_response({77}).empty());
}

TEST_CASE(
    "A panel between source and listener hides the source, and a material changes the level") {
    Scene scene = room_with_panel();
    Auralizer auralizer(scene, mono());
    auralizer.set_listener(at(4, 2, 1), 0);
    const SourceId source = auralizer.add_source({.position = {1, 2, 1}}, 0);
    const auto frame = [&] { rendered(auralizer, 1600, {256}, noise_at); };
    frame();
    frame();
    CHECK_FALSE(auralizer.visible(source));
    auralizer.set_transform(1, RigidTransform(at(0, 0, 5)));
    frame();
    frame();
    CHECK(auralizer.visible(source));
    CHECK_FALSE(auralizer.visible({99}));
    const auto late_energy = [&] {
        const auto response = auralizer.impulse_response(source)[0];
        return std::inner_product(response.begin() + 4800, response.end(), response.begin() + 4800,
                                  0.0);
    };
    for (int f = 0; f < 10; ++f) frame();
    const double before = late_energy();
    auralizer.set_material(0, Material{"felt", Bands::filled(0.9F), Bands::filled(0.5F)});
    frame();
    frame();
    // From 0.1 s on, more than ten reflections in the mean: at 0.1 instead of 0.7 each.
    CHECK(late_energy() < 1e-4 * before);
    auralizer.set_material(0, Material{"wall", Bands::filled(0.3F), Bands::filled(0.5F)});
    for (int f = 0; f < 12; ++f) frame();
    // As before: 1200 rays in ten frames leave some tenths of a decibel.
    CHECK(10 * std::log10(late_energy() / before) == Approx(0).margin(1));
}

TEST_CASE("Each listener has its own channels") {
    AuralizerOptions options = mono();
    options.listeners = 2;
    Auralizer auralizer(Scene{}, options);
    auralizer.add_source({});
    auralizer.set_listener(0, at(1, 0, 0));
    auralizer.set_listener(1, at(4, 0, 0));
    constexpr int kLength = 2000;
    const auto out =
        rendered(auralizer, kLength, {256}, [](std::int64_t n) { return n == 0 ? 1.0F : 0.0F; });
    const auto peak = [&](int channel) {
        const auto begin = out.begin() + channel * kLength;
        return std::max_element(begin, begin + kLength) - begin;
    };
    // 140 and 560 samples at 343 m/s, the pulse of the filters around them.
    const int latency = auralizer.latency_samples();
    CHECK(std::abs(peak(0) - latency - 140) <= 2);
    CHECK(std::abs(peak(1) - latency - 560) <= 2);
    CHECK(out[static_cast<std::size_t>(peak(0))] >
          3 * out[static_cast<std::size_t>(kLength + peak(1))]);
}

TEST_CASE("Invalid commands throw an error of one line, and rendering continues") {
    Scene scene = room_with_panel();
    Auralizer auralizer(scene, mono());
    CHECK_THROWS_AS(auralizer.set_transform(0, {}), InputError);  // not movable
    CHECK_THROWS_AS(auralizer.set_transform(2, {}), InputError);  // no such object
    CHECK_THROWS_AS(auralizer.set_material(0, "cheese"), InputError);
    CHECK_THROWS_AS(auralizer.set_material(9, "wall"), InputError);
    CHECK_THROWS_AS(auralizer.set_listener(1, Pose{}), InputError);
    auralizer.remove_source({5});
    auralizer.set_source({5}, Pose{});
    rendered(auralizer, 600, {256}, noise_at);
    AuralizerOptions bad = mono();
    bad.block = 0;
    CHECK_THROWS_AS(Auralizer(scene, bad), InputError);
    scene.simulation.rays = 0;
    CHECK_THROWS_AS(Auralizer(scene, mono()), InputError);
}

TEST_CASE("The parts of the sound have gains, and each part left out removes energy") {
    const auto energy = [](const PartGains& gains) {
        Auralizer auralizer(room_with_panel(), mono());
        auralizer.add_source({.position = {4, 1, 1}}, 0);  // not behind the panel
        auralizer.set_part_gains(gains, 0);
        const auto output = rendered(auralizer, 9600, {256}, noise_at);
        return std::inner_product(output.begin(), output.end(), output.begin(), 0.0);
    };
    CHECK(energy({.direct = 0, .early = 0, .late = 0}) == 0);  // exact: gains of zero
    const double direct = energy({.early = 0, .late = 0});
    const double discrete = energy({.late = 0});
    const double all = energy({});
    CHECK(direct > 0);
    CHECK(discrete > 1.05 * direct);
    CHECK(all > 1.05 * discrete);
    CHECK(energy({.direct = 0.5F, .early = 0, .late = 0}) ==
          Approx(direct / 4).epsilon(1e-5));  // rounding
    Auralizer auralizer(room_with_panel(), mono());
    CHECK_THROWS_AS(auralizer.set_part_gains({.late = -1}), InputError);
    CHECK_THROWS_AS(auralizer.set_part_gains({.early = NAN}), InputError);
}

TEST_CASE("Rays are set by number, or on the real-time clock by a share of the frame period") {
    Auralizer auralizer(room_with_panel(), mono());
    auralizer.add_source({.position = {1, 1, 1}}, 0);
    auralizer.set_rays(37, 0);
    rendered(auralizer, 512, {256}, noise_at);
    CHECK(auralizer.status().rays == 37);
    CHECK_THROWS_AS(auralizer.set_rays(0), InputError);
    CHECK_THROWS_AS(auralizer.set_frame_share(0.5), InputError);

    Auralizer live(room_with_panel(), mono(RenderClock::real_time));
    live.add_source({.position = {1, 1, 1}});
    CHECK_THROWS_AS(live.set_frame_share(-1), InputError);
    live.set_rays(20000);
    live.set_frame_share(0);  // fewer in each frame
    CHECK(test::eventually([&] {
        const int rays = live.status().rays;
        return rays > 55 && rays < 10000;
    }));
    live.set_rays(55);
    CHECK(test::eventually([&] { return live.status().rays == 55; }));
}

TEST_CASE("Threads of an auralizer have ordinary priority and end with its destructor") {
    // The system may list threads of earlier tests for a moment.
    std::set<std::string> before;
    REQUIRE(test::eventually([&] {
        const std::set<std::string> earlier = std::exchange(before, thread_ids());
        return before == earlier;
    }));
    const RenderClock clock = GENERATE(RenderClock::exact, RenderClock::real_time);
    {
        Scene scene = room_with_panel();
        scene.simulation.threads = 3;
        const RealtimePriority priority;
        Auralizer auralizer(scene, mono(clock));
        REQUIRE(thread_ids().size() >= before.size() + 3);
        for (const std::string& id : thread_ids())
            if (before.count(id) == 0) CHECK(sched_getscheduler(std::stoi(id)) == SCHED_OTHER);
    }
    // The system may list a thread for a moment after it has been joined.
    CHECK(test::eventually([&] { return thread_ids() == before; }));
}

TEST_CASE(
    "On the real-time clock a new source is in the second frame after its addition at the latest") {
    Auralizer auralizer(free_field({1, 0, 0}), mono(RenderClock::real_time));
    REQUIRE(test::eventually([&] { return auralizer.status().frames > 2; }));
    const std::uint64_t added_at = auralizer.status().frames;
    const SourceId source = auralizer.add_source({.position = {0, 2, 0}});
    std::uint64_t frames = added_at;
    REQUIRE(test::eventually([&] {
        const std::uint64_t seen = auralizer.status().frames;
        if (!auralizer.visible(source)) frames = seen;
        return auralizer.visible(source);
    }));
    // One frame was being computed; the next one has the source.
    CHECK(frames <= added_at + 1);
    const auto output = rendered(auralizer, 4800, {256}, noise_at);
    CHECK(std::any_of(output.begin(), output.end(), [](float x) { return std::abs(x) > 0.001F; }));
}

TEST_CASE("A source has its directivity and its orientation, on both clocks") {
    // The response of a cardioid is that of an omnidirectional source times its pressure, which is
    // equal in all bands.
    const Directivity cardioid = *Directivity::find("cardioid");
    for (const RenderClock clock : {RenderClock::exact, RenderClock::real_time}) {
        Scene scene = free_field({1, 0, 0});
        scene.sources[0].directivity = cardioid;
        scene.sources[0].yaw_rad = std::numbers::pi_v<float>;  // to the listener
        Auralizer auralizer(scene, mono(clock));
        const SourceId front = auralizer.sources()[0];
        const SourceId side = auralizer.add_source({.position = {1, 0, 0},
                                                    .yaw_rad = std::numbers::pi_v<float> / 2,
                                                    .directivity = cardioid});
        const SourceId omni = auralizer.add_source({.position = {1, 0, 0}, .yaw_rad = 1});
        const auto peak = [&](SourceId source) {
            std::vector<float> response;
            REQUIRE(test::eventually([&] {
                if (clock == RenderClock::exact) rendered(auralizer, 4800, {256}, noise_at);
                const auto channels = auralizer.impulse_response(source);
                if (!channels.empty()) response = channels[0];
                return !response.empty();
            }));
            return double{*std::max_element(response.begin(), response.end())};
        };
        const double one = peak(omni);
        CHECK(peak(front) / one == Approx(std::sqrt(3.0)).epsilon(1e-4));
        CHECK(peak(side) / one == Approx(std::sqrt(0.75)).epsilon(1e-4));
        // It turns to the front, in both ways.
        Pose pose = at(1, 0, 0, std::numbers::pi_v<float>);
        auralizer.set_source(side, pose);
        REQUIRE(
            test::eventually([&] { return std::abs(peak(side) / one - std::sqrt(3.0)) < 1e-3; }));
        pose.yaw_rad = 0;
        auralizer.set_source(side, pose);
        REQUIRE(test::eventually([&] { return peak(side) / one < 1e-3; }));
        pose.pitch_rad = std::nanf("");
        CHECK_THROWS_AS(auralizer.set_source(side, pose), InputError);
    }
}

TEST_CASE("After a failure of the propagation each call of render throws it again") {
    AuralizerOptions options = mono();
    options.before_frame = [](Auralizer&, double time_s) {
        if (time_s > 0) throw InputError("before_frame failed");
    };
    Auralizer auralizer(room_with_panel(), options);
    const auto render_second = [&] { return rendered(auralizer, 48000, {256}, noise_at); };
    CHECK_THROWS_WITH(render_second(), "before_frame failed");
    CHECK_THROWS_WITH(render_second(), "before_frame failed");
}

TEST_CASE("Numbers that are not finite, not shares or not rigid are refused, and nothing changes") {
    const auto render = [](bool hostile) {
        Scene scene = room_with_panel();
        Auralizer auralizer(scene, mono());
        const SourceId source = auralizer.add_source({.position = {1, 1, 1}}, 0);
        if (hostile) {
            const float nan = std::nanf("");
            Material negative;
            negative.absorption = Bands::filled(-1);
            Material leaking;  // transmits 0.5 of the energy and absorbs 0.1
            leaking.sound_reduction_db = Bands::filled(3);
            Material endless = leaking;
            endless.sound_reduction_db = Bands::filled(121);
            const RigidTransform scaled(glm::mat3(2.0F), Vec3(0));
            CHECK_THROWS_AS(auralizer.set_listener(at(nan, 0, 0)), InputError);
            CHECK_THROWS_AS(auralizer.set_listener(at(0, 0, 0, nan)), InputError);
            CHECK_THROWS_AS(auralizer.set_source(source, at(0, INFINITY, 0)), InputError);
            CHECK_THROWS_AS(auralizer.add_source({.position = {0, 0, nan}}), InputError);
            CHECK_THROWS_AS(auralizer.set_gain(source, INFINITY), InputError);
            CHECK_THROWS_AS(auralizer.set_material(0, negative), InputError);
            CHECK_THROWS_AS(auralizer.set_material(0, leaking), InputError);
            CHECK_THROWS_AS(auralizer.set_material(0, endless), InputError);
            CHECK_THROWS_AS(auralizer.set_transform(1, scaled), InputError);
            CHECK_THROWS_AS(auralizer.render({}, {}, 16), InputError);
        }
        return rendered(auralizer, 9600, {256}, noise_at);
    };
    CHECK(render(true) == render(false));
}

TEST_CASE("A source that is removed at the largest sample time is audible until then") {
    Auralizer auralizer(room_with_panel(), mono());
    const SourceId source = auralizer.add_source({.position = {1, 1, 1}}, 0);
    // The end of its reverberation must not overflow, which the sanitizer reports.
    auralizer.remove_source(source, std::numeric_limits<std::int64_t>::max() - 1);
    const std::vector<float> sound = rendered(auralizer, 24000, {256}, noise_at);
    CHECK(std::any_of(sound.end() - 4800, sound.end(), [](float x) { return x != 0; }));
}

TEST_CASE("A material that changes during a pause is audible after it") {
    Scene scene = room_with_panel();
    AuralizerOptions options = mono(RenderClock::real_time);
    Auralizer auralizer(scene, options);
    const SourceId source = auralizer.add_source({.position = {1, 1, 1}});
    const auto energy = [&] {
        double sum = 0;
        for (const auto& channel : auralizer.impulse_response(source))
            for (const float x : channel) sum += double{x} * double{x};
        return sum;
    };
    const auto play_until = [&](const std::function<bool()>& done) {
        return test::eventually([&] {
            rendered(auralizer, 256, {256}, noise_at);
            return done();
        });
    };
    REQUIRE(play_until([&] { return auralizer.status().frames > 20; }));
    const double before = energy();
    REQUIRE(before > 0);
    auralizer.pause();
    REQUIRE(play_until([&] { return auralizer.status().paused; }));
    Material open;
    open.absorption = Bands::filled(0.99F);
    auralizer.set_material(0, open);
    // Frames whose time passes during the pause apply the change.
    const auto until = std::chrono::steady_clock::now() + std::chrono::milliseconds(200);
    REQUIRE(play_until([&] { return std::chrono::steady_clock::now() > until; }));
    auralizer.resume();
    CHECK(play_until([&] { return energy() < 0.7 * before; }));
}
