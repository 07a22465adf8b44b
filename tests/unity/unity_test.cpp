#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "tests/unity/unity_host.h"

namespace unity_test {

namespace {

using namespace aula;
using namespace aula::test;

constexpr const char* kSpatializer = "Aula Spatializer";
constexpr const char* kRoom = "Aula Room";

struct Destroy {
    void operator()(aula_scene* scene) const { UnityPlugin::get().scene_destroy(scene); }
    void operator()(aula_room* room) const { UnityPlugin::get().room_destroy(room); }
};
using Scene = std::unique_ptr<aula_scene, Destroy>;
using Room = std::unique_ptr<aula_room, Destroy>;

/// A room that plays until it is destroyed.
struct Playing {
    explicit Playing(Room made) : room(std::move(made)) { UnityPlugin::get().play(room.get()); }
    Playing(const Playing&) = delete;
    Playing& operator=(const Playing&) = delete;
    ~Playing() { UnityPlugin::get().play(nullptr); }
    Room room;
};

/// A free field, or a box of brick, 8 x 6 x 3 m, whose corner is the origin of Aula's axes.
Scene make_scene(bool is_box) {
    const UnityPlugin& plugin = UnityPlugin::get();
    aula_scene* scene = nullptr;
    REQUIRE(plugin.scene_create(&scene) == AULA_OK);
    Scene owner(scene);
    if (!is_box) return owner;
    const std::vector<float> corners{0, 0, 0, 8, 0, 0, 8, 6, 0, 0, 6, 0,
                                     0, 0, 3, 8, 0, 3, 8, 6, 3, 0, 6, 3};
    const std::vector<std::uint32_t> triangles{0, 1, 2, 0, 2, 3, 4, 5, 6, 4, 6, 7,
                                               0, 1, 5, 0, 5, 4, 1, 2, 6, 1, 6, 5,
                                               2, 3, 7, 2, 7, 6, 3, 0, 4, 3, 4, 7};
    REQUIRE(plugin.scene_add_object(scene, "box", corners.data(), 8, triangles.data(), 12, "brick",
                                    0, nullptr) == AULA_OK);
    return owner;
}

Room make_room(aula_scene* scene, double sample_rate_hz) {
    aula_options options{};
    options.size = sizeof options;
    options.sample_rate_hz = sample_rate_hz;
    options.ir_length_s = 0.5;
    options.max_sources = 4;
    options.threads = 1;
    aula_room* room = nullptr;
    REQUIRE(UnityPlugin::get().room_create(scene, &options, &room) == AULA_OK);
    return Room(room);
}

aula_status status_of(const Room& room) {
    aula_status status{};
    status.size = sizeof status;
    REQUIRE(UnityPlugin::get().room_status(room.get(), &status) == AULA_OK);
    return status;
}

/// Calls a step of 10 ms until the room has its source, and has computed frames with what was
/// changed before. The thread that moves sources needs less than 100 ms; on a busy machine more.
template <typename Step>
void settle(const Room& room, const Step& step) {
    const auto wait_for = [&](const auto& holds) {
        for (int i = 0; i < 6000 && !holds(); ++i) {
            step();
            std::this_thread::sleep_for(std::chrono::milliseconds(10));
        }
        REQUIRE(holds());
    };
    int steps = 0;
    wait_for([&] { return ++steps > 50 && status_of(room).sources > 0; });
    const std::uint64_t frames = status_of(room).frames;
    wait_for([&] { return status_of(room).frames >= frames + 4; });
}

/// The ears of a mono signal that a source plays, in steps of the mixer.
Channels play(const Playing& playing, UnityEffect& source, UnityEffect& room,
              const std::vector<float>& signal, std::size_t block, int channels,
              int out_channels = 2) {
    Channels ears(static_cast<std::size_t>(out_channels));
    const auto width = static_cast<std::size_t>(channels);
    const auto out_width = static_cast<std::size_t>(out_channels);
    const auto step = [&](const std::vector<float>& mono) {
        std::vector<float> in(block * width);
        for (std::size_t n = 0; n < mono.size(); ++n)
            for (std::size_t c = 0; c < width; ++c) in[n * width + c] = mono[n];
        return room.process(source.process(in, channels, 2), 2, out_channels);
    };
    settle(playing.room, [&] { step({}); });
    for (std::size_t n = 0; n < signal.size(); n += block) {
        const std::vector<float> part(
            signal.begin() + static_cast<std::ptrdiff_t>(n),
            signal.begin() + static_cast<std::ptrdiff_t>(std::min(n + block, signal.size())));
        const std::vector<float> out = step(part);
        for (std::size_t i = 0; i < out.size(); ++i) ears[i % out_width].push_back(out[i]);
    }
    return ears;
}

double energy(const std::vector<float>& signal) {
    double sum = 0;
    for (const float x : signal) sum += static_cast<double>(x) * static_cast<double>(x);
    return sum;
}

double level_db(const std::vector<float>& signal, const std::vector<float>& of) {
    return 10 * std::log10(energy(signal) / energy(of));
}

/// The same poses by hand, in a room that the C interface plays: x to the front, y to the left.
Channels by_hand(aula_scene* scene, double sample_rate_hz, const aula_pose& source,
                 const aula_pose& head, const std::vector<float>& signal) {
    const UnityPlugin& plugin = UnityPlugin::get();
    aula_source number = 0;
    REQUIRE(plugin.scene_set_listener(scene, &head) == AULA_OK);
    REQUIRE(plugin.scene_add_source(scene, "s", &source, "omni", 0, &number) == AULA_OK);
    const Room room = make_room(scene, sample_rate_hz);
    Channels ears(2, std::vector<float>(signal.size()));
    std::vector<float> unused(480);
    float* const before[] = {unused.data(), unused.data()};
    settle(room, [&] { plugin.room_process(room.get(), nullptr, 0, before, 2, 480); });
    const aula_signal input{number, signal.data()};
    float* const outputs[] = {ears[0].data(), ears[1].data()};
    REQUIRE(plugin.room_process(room.get(), &input, 1, outputs, 2,
                                static_cast<std::int32_t>(signal.size())) == AULA_OK);
    return ears;
}

}  // namespace

TEST_CASE("The plugin defines a spatializer with two parameters, and an effect of the mixer") {
    const unity::EffectDefinition& spatializer = UnityPlugin::get().effect(kSpatializer);
    CHECK(spatializer.size == sizeof spatializer);
    CHECK(spatializer.parameter_size == sizeof(unity::ParameterDefinition));
    CHECK(spatializer.flags == (unity::kIsSpatializer | unity::kAppliesDistance));
    CHECK(spatializer.parameters == 2);
    CHECK(UnityPlugin::get().effect(kRoom).flags == unity::kNeedsSpatializerData);
    CHECK(UnityPlugin::get().effect(kRoom).channels == 0);

    UnityEffect source(kSpatializer, 48000, 512);
    for (int i = 0; i < 2; ++i) {
        const unity::ParameterDefinition& parameter = spatializer.parameter_definitions[i];
        float value = -1;
        CHECK(source.get(i, value) == unity::kOk);
        CHECK(value == parameter.initial);
        CHECK(source.set(i, 1e9F) == unity::kOk);
        source.get(i, value);
        CHECK(value == parameter.greatest);
        CHECK(source.set(i, std::nanf("")) == unity::kUnsupported);
    }
    float value = 0;
    for (const int index : {-1, 2}) {
        CHECK(source.set(index, 0) == unity::kUnsupported);
        CHECK(source.get(index, value) == unity::kUnsupported);
    }
    REQUIRE(source.data.attenuation != nullptr);
    CHECK(source.data.attenuation(nullptr, 4, 0.1F, &value) == unity::kOk);
    CHECK(value == 0.25F);
}

TEST_CASE("A source at the left is louder in the left ear, wherever the listener looks") {
    const unsigned rate_hz = GENERATE(44100U, 48000U);
    const std::size_t block = GENERATE(256U, 1024U, 2048U);
    const int channels = block == 1024 ? 1 : 2;
    INFO(rate_hz << " Hz, blocks of " << block << ", " << channels << " channels");
    const Scene scene = make_scene(false);
    const Playing playing(make_room(scene.get(), rate_hz));
    UnityEffect room(kRoom, rate_hz, static_cast<unsigned>(block));
    const std::vector<float> signal = noise(8192);
    // The listener at (1, 2, 3) looks along z, along x, and down, with the right along -z.
    const UnityTransform listeners[] = {
        {{1, 2, 3}, {1, 0, 0}, {0, 0, 1}},
        {{1, 2, 3}, {0, 0, -1}, {1, 0, 0}},
        {{1, 2, 3}, {0, 0, -1}, {0, -1, 0}},
    };
    for (const UnityTransform& listener : listeners) {
        for (const float side : {-2.0F, 2.0F}) {
            UnityTransform at;
            for (std::size_t i = 0; i < 3; ++i)
                at.position[i] = listener.position[i] + side * listener.right[i];
            UnityEffect source(kSpatializer, rate_hz, static_cast<unsigned>(block));
            source.place(at, listener);
            room.place({}, listener);
            const Channels ears = play(playing, source, room, signal, block, channels);
            INFO("side " << side << ", front " << listener.front[0] << " " << listener.front[1]);
            CHECK((side < 0 ? 1 : -1) * level_db(ears[0], ears[1]) > 6);
        }
    }
}

TEST_CASE("In a free field the effects give the samples of the C interface") {
    const std::vector<float> signal = noise(12000);
    const Scene scene = make_scene(false);
    const Playing playing(make_room(scene.get(), 48000));
    UnityEffect room(kRoom, 48000, 512);
    UnityEffect source(kSpatializer, 48000, 512);
    // 20 degrees to the right and 1 m higher; the head is turned to the left by 30 degrees and
    // tilted to the right by 90.
    const UnityTransform at{{1, 2.5F, 4}, {1, 0, 0}, {0, 0, 1}};
    const float c = std::cos(std::acos(-1.0F) / 6), s = 0.5F;
    const UnityTransform listener{{0, 1.5F, 1}, {0, -1, 0}, {-s, 0, c}};
    source.place(at, listener);
    room.place({}, listener);
    const Channels ears = play(playing, source, room, signal, 500, 2);
    const aula_pose source_pose{{4, -1, 2.5F}, 0, 0, 0};
    const float quarter = std::acos(0.0F);
    const aula_pose head{{1, 0, 1.5F}, quarter / 3, 0, quarter};
    const Channels reference = by_hand(make_scene(false).get(), 48000, source_pose, head, signal);
    for (std::size_t ear = 0; ear < 2; ++ear) {
        REQUIRE(ears[ear].size() == signal.size());
        std::vector<float> difference(signal.size());
        for (std::size_t n = 0; n < signal.size(); ++n)
            difference[n] = ears[ear][n] - reference[ear][n];
        CHECK(level_db(difference, reference[ear]) < -60);
    }
    // Directivity and gain: a cardioid that faces away, 6 dB louder.
    REQUIRE(source.set(0, 6) == unity::kOk);
    REQUIRE(source.set(1, 2) == unity::kOk);
    const Channels away = play(playing, source, room, signal, 500, 2);
    CHECK(level_db(away[0], ears[0]) < -6);
    REQUIRE(source.set(1, 0) == unity::kOk);
    const Channels louder = play(playing, source, room, signal, 500, 2);
    CHECK(level_db(louder[0], ears[0]) == Approx(6).margin(0.05));
    // Both ears in one channel.
    const Channels mono = play(playing, source, room, signal, 500, 1, 1);
    CHECK(mono.size() == 1);
    CHECK(std::abs(mono[0][6000] - (louder[0][6000] + louder[1][6000]) / 2) < 1e-3F);
}

TEST_CASE("In a box the effects sound as the C interface does") {
    const std::vector<float> signal = noise(24000);
    const Scene scene = make_scene(true);
    const Playing playing(make_room(scene.get(), 48000));
    UnityEffect room(kRoom, 48000, 1024);
    UnityEffect source(kSpatializer, 48000, 1024);
    const UnityTransform at{{-4, 1.5F, 6}, {1, 0, 0}, {0, 0, 1}};
    const UnityTransform listener{{-2, 1.6F, 2}, {1, 0, 0}, {0, 0, 1}};
    source.place(at, listener);
    room.place({}, listener);
    const Channels ears = play(playing, source, room, signal, 1000, 2);
    const Channels reference = by_hand(make_scene(true).get(), 48000, {{6, 4, 1.5F}, 0, 0, 0},
                                       {{2, 2, 1.6F}, 0, 0, 0}, signal);
    for (std::size_t ear = 0; ear < 2; ++ear)
        CHECK(level_db(ears[ear], reference[ear]) == Approx(0).margin(0.5));
    // It reverberates after 100 ms.
    std::vector<float> click(24000);
    click[0] = 1;
    const std::vector<float> left = play(playing, source, room, click, 1000, 2)[0];
    const std::vector<float> late(left.begin() + 4800, left.end());
    CHECK(energy(late) > 0.01 * energy(left));
}

TEST_CASE("Without a room that is heard, or in two dimensions, the sound passes") {
    const std::vector<float> in = noise(1024);
    UnityEffect source(kSpatializer, 48000, 512);
    CHECK(source.process(in, 2, 2) == in);
    CHECK(UnityPlugin::get().is_heard() == 0);
    UnityEffect room(kRoom, 48000, 512);
    CHECK(room.process(in, 2, 2) == in);
    const Scene scene = make_scene(false);
    {
        const Playing playing(make_room(scene.get(), 48000));
        CHECK(UnityPlugin::get().is_heard() == 1);
        CHECK(source.process(in, 2, 2) == std::vector<float>(1024));
        source.data.spatial_blend = 0;
        CHECK(source.process(in, 2, 2) == in);
        // Of several effects of the mixer the first one renders.
        UnityEffect second(kRoom, 48000, 512);
        CHECK(second.process(in, 2, 2) == in);
        // Six channels: the ears are the first two.
        const std::vector<float> surround = room.process(noise(6 * 512), 6, 6);
        CHECK(surround[5] == noise(6 * 512)[5]);
    }
    source.data.spatial_blend = 1;
    CHECK(source.process(in, 2, 2) == in);
    CHECK(UnityPlugin::get().is_heard() == 0);
}

TEST_CASE("Sources and rooms come and go while the mixer runs") {
    const Scene scene = make_scene(false);
    UnityEffect room(kRoom, 48000, 256);
    std::atomic<bool> ends = false;
    std::atomic<int> rendered = 0;
    // The mixer of the engine processes no effect while one comes or goes.
    std::mutex mixer;
    std::vector<std::unique_ptr<UnityEffect>> sources;
    std::thread audio([&] {
        const std::vector<float> in = noise(512);
        while (!ends) {
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
            const std::lock_guard lock(mixer);
            for (const auto& source : sources) source->process(in, 2, 2);
            const std::vector<float> out = room.process(std::vector<float>(512), 2, 2);
            if (out[10] != 0) ++rendered;
        }
    });
    for (int i = 0; i < 3; ++i) {
        const Playing playing(make_room(scene.get(), 48000));
        for (int n = 0; n < 6; ++n) {
            {
                const std::lock_guard lock(mixer);
                if (n < 3)
                    sources.push_back(std::make_unique<UnityEffect>(kSpatializer, 48000, 256));
                sources.back()->place({{static_cast<float>(n), 0, 2}}, {});
                if (n == 4) {
                    sources.clear();
                    sources.push_back(std::make_unique<UnityEffect>(kSpatializer, 48000, 256));
                }
            }
            std::this_thread::sleep_for(std::chrono::milliseconds(40));
        }
        // The last source is heard, and those that went have left.
        const int before = rendered;
        const auto holds = [&] {
            return rendered > before && status_of(playing.room).sources == 1;
        };
        for (int n = 0; n < 6000 && !holds(); ++n)
            std::this_thread::sleep_for(std::chrono::milliseconds(10));
        CHECK(holds());
        const std::lock_guard lock(mixer);
        sources.clear();
    }
    ends = true;
    audio.join();
    char text[256];
    CHECK(UnityPlugin::get().take_problem(text, sizeof text) == 0);
}

TEST_CASE("A source for which the room has no place is a problem that is told once") {
    const Scene scene = make_scene(false);
    const Playing playing(make_room(scene.get(), 48000));
    UnityEffect room(kRoom, 48000, 256);
    room.process(std::vector<float>(512), 2, 2);
    std::vector<std::unique_ptr<UnityEffect>> sources;
    for (int i = 0; i < 5; ++i) {
        sources.push_back(std::make_unique<UnityEffect>(kSpatializer, 48000, 256));
        sources.back()->process(noise(512), 2, 2);
    }
    char text[256] = "";
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (UnityPlugin::get().take_problem(text, sizeof text) == 0 &&
           std::chrono::steady_clock::now() < end)
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
    INFO(text);
    CHECK(std::string(text).find("sources") != std::string::npos);
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    CHECK(UnityPlugin::get().take_problem(text, sizeof text) == 0);
}

}  // namespace unity_test
