#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "apps/room/frames/ray_budget.h"
#include "aula/audio/realtime.h"
#include "aula/auralizer.h"
#include "tests/room/auralizer/auralizer_rendering.h"
#include "tests/support/test_scenes.h"

namespace {

using namespace aula;
using namespace aula::test;

/// Two listeners in the room, with changes of every kind.
std::vector<float> render_with_changes(const std::vector<int>& sizes, int threads,
                                       OutputFormat output, bool sample_by_sample = false) {
    Scene scene = room_with_panel();
    scene.simulation.threads = threads;
    AuralizerOptions options = mono();
    options.output = output;
    options.sample_by_sample = sample_by_sample;
    options.listeners = 2;
    options.max_sources = 3;
    Auralizer auralizer(scene, options);
    auralizer.set_listener(1, at(1, 3, 1.5F), 0);
    const SourceId first = auralizer.add_source({.position = {1, 1, 1}}, 0);
    auralizer.set_listener(at(4, 2, 1, 0.7F), 1001);
    auralizer.set_transform(1, RigidTransform(at(0.3F, 0, 0, 0.5F)), 2003);
    const SourceId second =
        auralizer.add_source({.position = {1, 3, 2}, .gain_db = -3, .name = "second"}, 3007);
    auralizer.set_material(0, "curtain", 4999);
    auralizer.set_source(first, at(1.5F, 1, 1), 5003);
    auralizer.set_gain(second, -9, 6007);
    auralizer.remove_source(first, 7001);
    auralizer.add_source({.position = {2, 3, 2}}, 8009);
    return rendered(auralizer, 12000, sizes, noise_at);
}

/// Number of equal samples from the start.
std::int64_t same_until(const std::vector<float>& a, const std::vector<float>& b) {
    return std::mismatch(a.begin(), a.end(), b.begin()).first - a.begin();
}

}  // namespace

TEST_CASE("On the exact clock any blocks and any number of threads give the same bytes") {
    const OutputFormat output = GENERATE(OutputFormat::mono, OutputFormat::binaural);
    const std::vector<float> reference = render_with_changes({256}, 1, output);
    REQUIRE(std::any_of(reference.begin(), reference.end(), [](float x) { return x != 0; }));
    for (const std::vector<int>& sizes :
         {std::vector<int>{1}, {17}, {64}, {4096}, {1, 300, 17, 4096, 2, 255, 257}}) {
        INFO("calls of " << sizes[0]);
        CHECK((render_with_changes(sizes, 1, output) == reference));
    }
    CHECK((render_with_changes({256}, 3, output) == reference));
    // The result is also independent of the caller's floating-point mode.
    const FlushDenormals flush;
    CHECK((render_with_changes({256}, 1, output) == reference));
}

TEST_CASE("Sample by sample any blocks give the same bytes, without latency") {
    const std::vector<float> reference =
        render_with_changes({256}, 1, OutputFormat::binaural, true);
    for (const std::vector<int>& sizes : {std::vector<int>{1}, {17}, {4096}, {1, 300, 17, 255}}) {
        INFO("calls of " << sizes[0]);
        CHECK((render_with_changes(sizes, 1, OutputFormat::binaural, true) == reference));
    }
    // 1 m in a free field: 140 samples.
    AuralizerOptions options = mono();
    options.sample_by_sample = true;
    Auralizer auralizer(free_field({1, 0, 0}), options);
    CHECK(auralizer.latency_samples() == 0);
    const auto click = [](std::int64_t n) { return n == 0 ? 1.0F : 0.0F; };
    const std::vector<float> output = rendered(auralizer, 480, {64}, click);
    const auto loudest = std::max_element(output.begin(), output.end());
    CHECK(loudest - output.begin() == 140);
}

TEST_CASE("Sample by sample a static room sounds as in blocks") {
    for (const OutputFormat output : {OutputFormat::binaural, OutputFormat::toa}) {
        const auto play = [&](bool sample_by_sample) {
            AuralizerOptions options = mono();
            options.output = output;
            options.sample_by_sample = sample_by_sample;
            Auralizer auralizer(test::small_room(), options);
            const std::size_t latency = static_cast<std::size_t>(auralizer.latency_samples());
            const std::size_t length = 12000;
            const auto all = rendered(auralizer, length, {500}, noise_at);
            std::vector<float> undelayed;
            for (std::size_t c = 0; c < channel_count(output); ++c) {
                const std::span channel(all.data() + c * length + latency, length - 256);
                undelayed.insert(undelayed.end(), channel.begin(), channel.end());
            }
            return undelayed;
        };
        const std::vector<float> blocks = play(false);
        const std::vector<float> samples = play(true);
        float largest = 0;
        float difference = 0;
        for (std::size_t n = 0; n < blocks.size(); ++n) {
            largest = std::max(largest, std::abs(blocks[n]));
            difference = std::max(difference, std::abs(samples[n] - blocks[n]));
        }
        REQUIRE(largest > 0.01F);
        // Sums of some thousand products are rounded in another order.
        CHECK(difference < 1e-5F * largest);
    }
}

TEST_CASE("A pause on the exact clock is the same for any blocks and stops the time") {
    const auto play = [](const std::vector<int>& sizes) {
        Auralizer auralizer(room_with_panel(), mono());
        auralizer.add_source({.position = {1, 1, 1}}, 0);
        std::vector<float> all;
        for (int part = 0; part < 3; ++part) {
            const auto output = rendered(auralizer, 3000, sizes, noise_at);
            all.insert(all.end(), output.begin(), output.end());
            if (part == 0) auralizer.pause();
            if (part == 1) CHECK(auralizer.status().paused);
            if (part == 1) auralizer.resume();
        }
        // The fade lasts 960 samples.
        CHECK(auralizer.status().samples == 6960);
        CHECK(std::all_of(all.begin() + 3960, all.begin() + 6000, [](float x) { return x == 0; }));
        return all;
    };
    const std::vector<float> reference = play({256});
    CHECK((play({1}) == reference));
    CHECK((play({1000, 17}) == reference));
}

TEST_CASE("Changes made just before their sample time give the same bytes as early ones") {
    const auto play = [](bool early, int size) {
        Auralizer auralizer(room_with_panel(), mono());
        const SourceId source = auralizer.add_source({.position = {1, 1, 1}}, 0);
        const auto change = [&](std::int64_t time) {
            auralizer.set_listener(at(4, 2, 1), time);
            auralizer.set_gain(source, -6, time);
            auralizer.set_transform(1, RigidTransform(at(0.3F, 0, 0)), time);
        };
        if (early) change(3000);
        return rendered(auralizer, 6000, {size}, noise_at, [&](std::int64_t position) {
            if (!early && position == 3000) change(kNow);
        });
    };
    const std::vector<float> early = play(true, 256);
    CHECK((play(false, 1000) == early));
    CHECK((play(false, 250) == early));
}

TEST_CASE("Frames that are computed ahead give the same bytes") {
    const auto play = [](bool ahead) {
        Scene scene = room_with_panel();
        scene.sources = test::small_room().sources;
        Trajectory path{{{0, at(1, 1, 1)}, {0.2, at(2, 1, 1)}}, false};
        scene.sources[0].path = path;
        scene.objects[1].path = Trajectory{{{0, at(0, 0, 0)}, {0.2, at(0.5F, 0, 0, 1)}}, false};
        AuralizerOptions options = mono();
        options.before_frame = follow_paths(scene);
        Auralizer auralizer(scene, options);
        if (ahead) auralizer.commit(1'000'000);
        return rendered(auralizer, 9000, {256}, noise_at);
    };
    CHECK((play(true) == play(false)));
}

TEST_CASE(
    "A change takes effect at its sample time, a position in the first frame at or after it") {
    // Frames begin every 1600 samples.
    const auto play = [](const std::function<void(Auralizer&, SourceId)>& change) {
        Auralizer auralizer(free_field({1, 0, 0}), mono());
        if (change) change(auralizer, auralizer.sources()[0]);
        return rendered(auralizer, 8000, {256}, noise_at);
    };
    const std::vector<float> plain = play({});
    const std::int64_t latency = 256;
    const auto differs = [&](const std::function<void(Auralizer&, SourceId)>& change) {
        return same_until(plain, play(change)) - latency;
    };
    CHECK(differs([](Auralizer& a, SourceId s) { a.set_source(s, at(2, 0, 0), 3200); }) == 3200);
    // The second sample of a fade may round to the one before.
    CHECK(differs([](Auralizer& a, SourceId s) { a.set_source(s, at(2, 0, 0), 3201); }) ==
          Approx(4800).margin(2));
    CHECK(differs([](Auralizer& a, SourceId s) { a.set_gain(s, -6, 3201); }) ==
          Approx(4800).margin(2));
    // The fade's first weights are 6e-6 of a sample: rounding; and the sound is delayed by 140
    // samples.
    CHECK(differs([](Auralizer& a, SourceId s) { a.remove_source(s, 3333); }) ==
          Approx(3333 + 140).margin(20));
    CHECK(differs([](Auralizer& a, SourceId) {
              a.add_source({.position = {0, 1, 0}}, 3333);
          }) == Approx(4800).margin(20));
}

TEST_CASE("An initial source plays its first sample without a fade, after the propagation delay") {
    Auralizer auralizer(free_field({3.432F, 0, 0}), mono());
    const auto output =
        rendered(auralizer, 2000, {100}, [](std::int64_t n) { return n == 0 ? 1.0F : 0.0F; });
    // 3.432 m at 343.2 m/s are 480 samples. 0.1 dB: rounding in the design of the filters.
    REQUIRE(static_cast<double>(output[480 + 256]) == Approx(1 / 3.432).epsilon(0.0116));
    CHECK(auralizer.latency_samples() == 256);
}

TEST_CASE("An orientation that is set before the first sample applies from the first sample on") {
    const auto render = [](float scene_yaw_rad, float set_yaw_rad) {
        Scene scene = free_field({1, 0, 0});
        scene.listener.pose.yaw_rad = scene_yaw_rad;
        AuralizerOptions options = mono();
        options.output = OutputFormat::binaural;
        Auralizer auralizer(scene, options);
        auralizer.set_listener(at(0, 0, 0, set_yaw_rad), 0);
        return rendered(auralizer, 2048, {256}, noise_at);
    };
    CHECK(render(0, 1.5F) == render(1.5F, 1.5F));
}

TEST_CASE("Changes of a source that begins later take effect at its beginning") {
    const auto render = [](std::int64_t change_at, bool removed) {
        Auralizer auralizer(room_with_panel(), mono());
        const SourceId source = auralizer.add_source({.position = {1, 1, 1}}, 4800);
        auralizer.set_gain(source, -6, change_at);
        auralizer.set_source(source, at(1, 3, 2), change_at);
        if (removed) {
            auralizer.remove_source(source, change_at);
            CHECK(auralizer.sources().empty());
            auralizer.remove_source(source, std::numeric_limits<std::int64_t>::max());
        }
        return rendered(auralizer, 14400, {256}, noise_at);
    };
    const bool removed = GENERATE(false, true);
    const std::vector<float> early = render(kNow, removed);
    CHECK(early == render(4800, removed));
    CHECK(std::any_of(early.begin(), early.end(), [](float x) { return x != 0; }) == !removed);
}

TEST_CASE("Paths of a scene move only the sources, listener and objects that have one") {
    Scene scene = room_with_panel();
    scene.objects[1].path = Trajectory{{{0, {}}, {1, at(0.5F, 0, 0)}}, false};
    const auto render = [&](bool follows) {
        AuralizerOptions options = mono();
        if (follows) options.before_frame = follow_paths(scene);
        Scene still = scene;
        if (!follows) {
            still.objects[1].path.reset();
            options.before_frame = [&](Auralizer& auralizer, double time_s) {
                auralizer.set_transform(1, scene.objects[1].transform_at(time_s));
            };
        }
        Auralizer auralizer(follows ? scene : still, options);
        auralizer.add_source({.position = {1, 1, 1}}, 0);
        auralizer.set_listener(at(4, 3, 1.5F), 0);
        return rendered(auralizer, 9600, {256}, noise_at);
    };
    CHECK(render(true) == render(false));
}

TEST_CASE("Exact rendering takes as many rays as its quality allows, unless they are given") {
    struct Rendered {
        std::vector<float> samples;
        int rays = 0;  ///< of the last frame
    };
    const auto render = [](Quality quality, std::optional<int> rays, int threads) {
        Scene scene = small_room();
        scene.materials[0].absorption = Bands::filled(0.02F);
        scene.simulation.ir_length_s = 4;
        scene.simulation.quality = quality;
        scene.simulation.rays = rays;
        scene.simulation.threads = threads;
        AuralizerOptions options = mono();
        options.max_sources = 4;
        Auralizer auralizer(scene, options);
        for (const float x : {1.0F, 2.0F, 3.0F})
            auralizer.add_source({.position = {x, 1, 1.2F}}, 0);
        Rendered result{rendered(auralizer, 16000, {256}, noise_at), 0};
        result.rays = auralizer.status().rays;
        return result;
    };
    const Rendered draft = render(Quality::draft, {}, 1);
    CHECK(draft.rays >= fewest_rays(3));
    CHECK(draft.rays < render(Quality::normal, {}, 1).rays);
    const Rendered fine = render(Quality::fine, {}, 1);
    CHECK(fine.rays == Simulation::kRays);
    CHECK(fine.samples != draft.samples);
    CHECK(fine.samples == render(Quality::draft, Simulation::kRays, 1).samples);
    CHECK(render(Quality::draft, 400, 1).rays == 400);
    const Rendered again = render(Quality::draft, {}, 3);
    CHECK(again.rays == draft.rays);
    CHECK(again.samples == draft.samples);
}
