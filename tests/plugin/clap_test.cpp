#include <clap/ext/audio-ports.h>
#include <clap/ext/latency.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "tests/plugin/clap_host.h"
#include "tests/support/temporary_folder.h"

namespace clap_test {

namespace {

using namespace aula;
using namespace aula::test;
using plugin::Control;

constexpr const char* kMono = "aula.room.binaural";
constexpr const char* kStereo = "aula.room.stereo.binaural";

double energy(const std::vector<float>& signal) {
    double sum = 0;
    for (const float x : signal) sum += static_cast<double>(x) * static_cast<double>(x);
    return sum;
}

std::string state_of(const std::string& scene) {
    return "{\"aula_room\": 1, \"scene\": \"" + scene + "\"}";
}

/// The state of a small room with few rays.
std::string small_room() {
    static const TemporaryFolder folder;
    static const std::string file = folder
                                        .write("room.json", R"({"aula": 1,
        "geometry": [{"box": [9, 7, 3], "material": "brick"}],
        "sources": [{"name": "s", "position": [6.5, 4.25, 1.5], "signal": "impulse"}],
        "listener": {"position": [3.5, 3.5, 1.5]},
        "simulation": {"rays": 200, "ir_length_s": 0.3}})")
                                        .generic_string();
    return state_of(file);
}

/// Instances share the HRTF: this one keeps it for those that follow.
void keep_hrtf() {
    static ClapHost* const keeper = [] {
        auto* const host = new ClapHost(kMono);
        host->load(small_room());
        host->set_offline(true);
        host->activate();
        host->run({noise(1)}, {1});
        return host;
    }();
    static_cast<void>(keeper);
}

/// A new instance that renders the small room offline.
Channels bounce(const std::string& id, const Channels& input, const std::vector<std::size_t>& sizes,
                const std::vector<ClapChange>& changes = {}) {
    keep_hrtf();
    ClapHost host(id);
    REQUIRE(host.load(small_room()));
    host.set_offline(true);
    REQUIRE(host.activate(48000, 64));
    const Channels output = host.run(input, sizes, changes);
    CHECK(host.misuses() == 0);
    return output;
}

/// A free field: a click arrives once.
const char* const kFreeField = R"({"aula": 1,
    "sources": [{"name": "s", "position": [3.432, 0, 0], "signal": "impulse"}],
    "listener": {"position": [0, 0, 0]}})";

}  // namespace

TEST_CASE("Rendered offline in blocks of any size a plugin gives the same bytes") {
    const auto id = GENERATE(as<std::string>{}, kMono, "aula.room.stereo.foa", "aula.room.toa");
    const bool is_stereo = id.find("stereo") != std::string::npos;
    Channels input{noise(1500)};
    if (is_stereo) input.push_back(noise(1500, 9));
    // Automation at samples that are no multiple of a block.
    std::vector<ClapChange> changes;
    for (std::size_t n = 0; n < 20; ++n)
        changes.push_back({61 * n, Control::source_x, 3 + 0.05 * static_cast<double>(n)});
    changes.push_back({705, Control::source_room_y, -0.75});
    changes.push_back({1305, Control::gain_db, -6.0});
    const Channels reference = bounce(id, input, {256}, changes);
    REQUIRE(reference.size() == (is_stereo ? 4U : id == kMono ? 2U : 16U));
    REQUIRE(energy(reference[0]) > 1e-4);
    for (const std::size_t size : {17U, 1000U}) {
        INFO("blocks of " << size);
        CHECK((bounce(id, input, {size}, changes) == reference));
    }
    CHECK((bounce(id, input, {1, 300, 8192, 17}, changes) == reference));
}

TEST_CASE("The same range gives the same bytes, whatever was played before") {
    const Channels input{noise(1000)};
    const Channels reference = bounce(kMono, input, {256});
    ClapHost host(kMono);
    REQUIRE(host.load(small_room()));
    REQUIRE(host.activate());
    host.run({noise(3000)}, {256});
    host.set_offline(true);
    CHECK((host.run(input, {512}) == reference));
    // It begins where the transport rolls, and rolls on without a new beginning.
    host.roll(44100 * 7 + 3);
    CHECK((host.run(input, {100}) == reference));
    CHECK((host.run(input, {100}) != reference));
    host.roll(5);
    CHECK((host.run(input, {77}) == reference));
    host.on_audio_thread([&] { host.plugin().reset(&host.plugin()); });
    CHECK((host.run(input, {1000}) == reference));
    CHECK(host.misuses() == 0);
}

TEST_CASE("A click arrives when the air lets it: the latency is 0") {
    const TemporaryFolder folder;
    const std::string scene = folder.write("free.json", kFreeField).generic_string();
    const double rate_hz = GENERATE(22050.0, 48000.0, 192000.0);
    ClapHost host("aula.room.foa");
    REQUIRE(host.load(state_of(scene)));
    host.set_offline(true);
    REQUIRE(host.activate(rate_hz));
    std::vector<float> click(static_cast<std::size_t>(rate_hz / 20));
    click[0] = 1;
    const Channels output = host.run({click}, {333});
    const auto loudest = std::max_element(output[0].begin(), output[0].end());
    // 10 ms of air, and a millisecond of filters.
    CHECK(static_cast<double>(loudest - output[0].begin()) / rate_hz ==
          Approx(3.432 / 343.2).margin(1e-3));
    CHECK(host.extension<clap_plugin_latency_t>(CLAP_EXT_LATENCY).get(&host.plugin()) == 0);
    const std::uint32_t tail =
        host.extension<plugin::TailExtension>(plugin::kTailExtension).get(&host.plugin());
    CHECK(tail > rate_hz / 100);
}

TEST_CASE("A stereo input is two sources a metre apart, which the yaw turns") {
    const std::vector<float> sound = noise(1200);
    const std::vector<float> silence(sound.size());
    // What the ears get of an input's direct sound.
    const auto ears = [&](const Channels& input, double source_yaw) {
        const Channels output = bounce(kStereo, input, {480},
                                       {{0, Control::early, 0},
                                        {0, Control::late, 0},
                                        {0, Control::listener_yaw, 0.01},
                                        {0, Control::source_x, 5},
                                        {0, Control::source_y, 3.5},
                                        {0, Control::source_z, 1.5},
                                        {0, Control::listener_x, 4},
                                        {0, Control::listener_y, 3.5},
                                        {0, Control::listener_z, 1.5},
                                        {0, Control::source_yaw, source_yaw}});
        return 10 * std::log10(energy(output[0]) / energy(output[1]));
    };
    const double left_db = ears({sound, silence}, 0);
    const double right_db = ears({silence, sound}, 0);
    CHECK(left_db > 3);
    CHECK(right_db < -3);
    CHECK(ears({sound, sound}, 0) == Approx(0).margin(2));
    CHECK(ears({sound, silence}, 180) == Approx(right_db).margin(0.5));
}

TEST_CASE("Parameters are those of the core, with texts, and the bypass") {
    const ClapHost host(kMono);
    const auto& parameters = host.extension<clap_plugin_params_t>(CLAP_EXT_PARAMS);
    const clap_plugin_t* const plugin = &host.plugin();
    REQUIRE(parameters.count(plugin) == plugin::kControls);
    std::set<std::string> names;
    for (std::uint32_t i = 0; i < plugin::kControls; ++i) {
        clap_param_info_t info;
        REQUIRE(parameters.get_info(plugin, i, &info));
        CHECK(info.id == i);
        names.insert(info.name);
        CHECK(info.min_value <= info.default_value);
        CHECK(info.default_value <= info.max_value);
        CHECK(host.get(static_cast<Control>(i)) == info.default_value);
        for (const double value : {info.min_value, info.default_value, info.max_value}) {
            char text[64];
            double read = -1;
            REQUIRE(parameters.value_to_text(plugin, i, value, text, sizeof text));
            REQUIRE(parameters.text_to_value(plugin, i, text, &read));
            INFO(info.name << ": " << text);
            CHECK(read == Approx(value).margin(0.006));
        }
    }
    CHECK(names.size() == plugin::kControls);
    CHECK(names.count("Bypass") == 1);
    const auto text_of = [&](Control control, double value) {
        char text[64];
        parameters.value_to_text(plugin, static_cast<clap_id>(control), value, text, sizeof text);
        return std::string(text);
    };
    CHECK(text_of(Control::quality, 2) == "fine");
    CHECK(text_of(Control::source_x, 1.5) == "1.50 m");
    CHECK(text_of(Control::direct, 0) == "off");
    CHECK(text_of(Control::room, 3) == "tiled bathroom");
    char small[4];
    CHECK(parameters.value_to_text(plugin, 0, 1.5, small, sizeof small));
    CHECK(std::string(small) == "1.5");
    double value;
    CHECK_FALSE(parameters.text_to_value(plugin, 0, "near", &value));
    CHECK_FALSE(parameters.get_value(plugin, 4711, &value));
    clap_param_info_t info;
    CHECK_FALSE(parameters.get_info(plugin, plugin::kControls, &info));

    ClapHost bypassed(kMono);
    bypassed.set_offline(true);
    REQUIRE(bypassed.activate());
    bypassed.set(Control::enabled, 1);
    const Channels input{noise(500)};
    CHECK((bypassed.run(input, {100}) == Channels{input[0], input[0]}));
    CHECK(bypassed.get(Control::enabled) == 1);
}

TEST_CASE("The control room plays a scene that ships with the plugins") {
    const Channels input{noise(2000)};
    ClapHost host(kMono);
    REQUIRE(host.load(state_of(AULA_SOURCE_DIR "/scenes/shoebox.json")));
    host.set_offline(true);
    REQUIRE(host.activate());
    host.set(Control::quality, 0);
    const Channels reference = host.run(input, {256});
    CHECK((bounce(kMono, input, {256}, {{0, Control::quality, 0}, {0, Control::room, 2}}) ==
           reference));
    CHECK((bounce(kMono, input, {256}) != reference));
}

TEST_CASE("The state is saved and loaded in parts, and what is no state is refused") {
    const TemporaryFolder folder;
    const std::string scene = folder.write("free.json", kFreeField).generic_string();
    ClapHost host(kMono);
    REQUIRE(host.activate());
    host.set(Control::source_x, 2.5);
    host.set(Control::enabled, 1);
    host.run({noise(100)}, {100});
    REQUIRE(host.load("{\"aula_room\": 1, \"scene\": \"" + scene +
                      "\", \"seed\": 18446744073709551615, \"walls\": [1, 2],"
                      " \"controls\": {\"source_x\": 7.5, \"source_room_x\": -0.25, \"enabled\": "
                      "0, \"colour\": 3,"
                      " \"wet\": \"much\", \"gain_db\": 1e9}}"));
    CHECK(host.get(Control::source_x) == 7.5);
    CHECK(host.get(Control::source_room_x) == -0.25);
    CHECK(host.get(Control::enabled) == 1);  // bypassed
    CHECK(host.get(Control::wet) == 1);
    CHECK(host.get(Control::gain_db) == 24);
    const std::string state = host.save();
    CHECK(state == host.save(100000));
    for (const std::string part : {"walls", "colour", "18446744073709551615", "free.json"})
        CHECK(state.find(part) != std::string::npos);

    ClapHost other("aula.room.stereo.toa");
    REQUIRE(other.load(state, 1));
    CHECK(other.save() == state);
    for (const std::string& text :
         {std::string(), std::string("{}"), std::string("[]"), state.substr(0, state.size() / 2),
          std::string("\0\0\0\0", 4), std::string(100000, '['), std::string(2 << 20, ' ')}) {
        CHECK_FALSE(other.load(text, 4096));
        CHECK(other.save() == state);
    }
    // It plays as the first one does.
    host.deactivate();
    CHECK(host.save() == state);
    CHECK(host.misuses() == 0);
}

TEST_CASE("A scene that is gone is logged, and the default room plays") {
    ClapHost host(kMono);
    REQUIRE(host.load(state_of("/nowhere/room.json")));
    REQUIRE(host.activate());
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (host.logged().empty() && std::chrono::steady_clock::now() < end) {
        host.run({noise(256)}, {256});
        host.idle();
    }
    CHECK(host.logged().find("/nowhere/room.json") != std::string::npos);
    CHECK(energy(host.run({noise(9600)}, {256})[0]) > 0);
    CHECK(host.save().find("/nowhere/room.json") != std::string::npos);
    CHECK(host.misuses() == 0);
}

TEST_CASE("Calls in the wrong order or on the wrong thread are refused and do no harm") {
    ClapHost host(kMono);
    const clap_plugin_t* const plugin = &host.plugin();
    CHECK(host.run({noise(100)}, {100}).empty());  // not active
    CHECK_FALSE(host.activate(4000));
    CHECK_FALSE(host.activate(1e9));
    bool is_active = true;
    host.on_audio_thread([&] { is_active = host.activate(); });
    CHECK_FALSE(is_active);
    REQUIRE(host.activate());
    CHECK_FALSE(host.activate());
    const std::string state = host.save();
    // What belongs to the main thread, while it processes on another one.
    std::vector<std::string> saved;
    std::vector<bool> loaded;
    host.on_audio_thread([&] {
        saved.push_back(host.save());
        loaded.push_back(host.load(state));
        plugin->deactivate(plugin);
    });
    CHECK(saved == std::vector<std::string>{""});
    CHECK(loaded == std::vector<bool>{false});
    std::thread third([&] {
        saved.push_back(host.save());
        plugin->deactivate(plugin);
        plugin->reset(plugin);
        for (int i = 0; i < 1000; ++i) host.get(Control::source_x);
    });
    CHECK_FALSE(host.run({noise(2000)}, {100}).empty());
    third.join();
    CHECK(saved == std::vector<std::string>{"", ""});
    // Without buffers, or with too few channels.
    clap_process_t call{};
    call.frames_count = 64;
    CHECK(plugin->process(plugin, &call) == CLAP_PROCESS_ERROR);
    ClapHost stereo(kStereo);
    REQUIRE(stereo.activate());
    CHECK(stereo.run({noise(64)}, {64}).empty());
    CHECK_FALSE(stereo.run({noise(64), noise(64)}, {64}).empty());
    // Parameters of an instance that is not active, on the main thread.
    ClapHost idle(kMono);
    clap_event_param_value_t event{};
    event.header = {sizeof event, 0, CLAP_CORE_EVENT_SPACE_ID, CLAP_EVENT_PARAM_VALUE, 0};
    event.param_id = 0;
    event.value = 2.25;
    const clap_input_events_t in{&event, [](const clap_input_events_t*) { return 1U; },
                                 [](const clap_input_events_t* list, std::uint32_t) {
                                     return static_cast<const clap_event_header_t*>(list->ctx);
                                 }};
    idle.extension<clap_plugin_params_t>(CLAP_EXT_PARAMS).flush(&idle.plugin(), &in, nullptr);
    CHECK(idle.get(Control::source_x) == 2.25);
    CHECK(host.misuses() == 0);
}

}  // namespace clap_test
