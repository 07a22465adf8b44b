#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "tests/plugin/plugin_host.h"
#include "tests/support/temporary_folder.h"

namespace plugin_test {

namespace {

using namespace aula;
using namespace aula::test;
using plugin::Control;

float peak(const Channels& channels) {
    float largest = 0;
    for (const auto& channel : channels)
        for (const float x : channel) {
            if (!std::isfinite(x)) return std::numeric_limits<float>::infinity();
            largest = std::max(largest, std::abs(x));
        }
    return largest;
}

/// A new instance that renders on the exact clock.
Channels bounce(OutputFormat layout, std::span<const float> input,
                const std::vector<std::size_t>& sizes) {
    PluginHost host(layout);
    host.set_freewheel(1);
    host.set(Control::quality, 0);
    host.activate();
    return host.run(input, sizes);
}

/// A free field: a click arrives once.
const char* const kFreeField = R"({"aula": 1,
    "sources": [{"name": "s", "position": [3.432, 0, 0], "signal": "impulse"}],
    "listener": {"position": [0, 0, 0]}})";

}  // namespace

TEST_CASE("Rendered in blocks of any size a plugin gives the same bytes, without latency") {
    const auto layout = GENERATE(OutputFormat::binaural, OutputFormat::foa, OutputFormat::toa);
    const std::vector<float> input = noise(4500);
    const Channels reference = bounce(layout, input, {256});
    REQUIRE(reference.size() == channel_count(layout));
    REQUIRE(peak(reference) > 0.001F);
    REQUIRE(peak(reference) < 10);
    for (const std::size_t size : {1U, 17U, 64U, 1024U, 4096U}) {
        INFO("blocks of " << size);
        CHECK((bounce(layout, input, {size}) == reference));
    }
    CHECK((bounce(layout, input, {1, 300, 8192, 17}) == reference));
}

TEST_CASE("A plugin renders the same range twice with the same bytes, whatever it played before") {
    const std::vector<float> input = noise(4000);
    const Channels reference = bounce(OutputFormat::binaural, input, {256});
    PluginHost host(OutputFormat::binaural);
    host.set(Control::quality, 0);
    host.activate();
    for (int time = 0; time < 2; ++time) {
        host.set_freewheel(0);
        CHECK(peak(host.run(noise(10000), {256})) > 0);
        host.set_freewheel(1);
        CHECK((host.run(input, {512}) == reference));
    }
    // The range begins where the transport rolls.
    host.send_position(0, 0);
    host.run(noise(777), {777});
    host.send_position(48000, 1);
    CHECK((host.run(input, {100}) == reference));
    host.send_position(96000, 1);
    CHECK((host.run(input, {100}) == reference));
    // It has rolled on to where it is.
    const Channels before = host.run(input, {4000});
    host.send_position(96000 + 8000, 1);
    CHECK((host.run(input, {4000}) != reference));
}

TEST_CASE("At sample rates outside 8 to 384 kHz a plugin cannot be instantiated") {
    for (const double rate_hz : {4000.0, 7999.0, 384001.0, 768000.0, 0.0, std::nan("")}) {
        INFO(rate_hz);
        CHECK_THROWS_WITH(PluginHost(OutputFormat::binaural, rate_hz), "no instance");
    }
    for (const double rate_hz : {8000.0, 384000.0})
        CHECK_NOTHROW(PluginHost(OutputFormat::binaural, rate_hz));
}

TEST_CASE("A plugin works at all sample rates and reports no latency") {
    struct Format {
        OutputFormat layout;
        double rate_hz;
    };
    for (const Format& format : {Format{OutputFormat::binaural, 22050.0},
                                 {OutputFormat::binaural, 44100.0},
                                 {OutputFormat::binaural, 96000.0},
                                 {OutputFormat::binaural, 192000.0},
                                 {OutputFormat::foa, 44100.0},
                                 {OutputFormat::foa, 96000.0},
                                 {OutputFormat::toa, 44100.0},
                                 {OutputFormat::toa, 96000.0}}) {
        const double rate_hz = format.rate_hz;
        INFO(channel_count(format.layout) << " channels, " << rate_hz << " Hz");
        PluginHost host(format.layout, rate_hz);
        host.set_freewheel(1);
        host.set(Control::quality, 0);
        host.activate();
        std::vector<float> click(static_cast<std::size_t>(rate_hz / 20));
        click[0] = 1;
        const Channels output = host.run(click, {512});
        CHECK(peak(output) > 0.01F);
        CHECK(peak(output) < 2);
        CHECK(host.latency() == 0);
        // The direct sound travels 3.09 m, and the ear nearer to the source is up to 0.3 ms before
        // the centre of the head; the filters of the ears begin within 1 ms.
        const auto loudest = std::max_element(output[0].begin(), output[0].end());
        CHECK(static_cast<double>(loudest - output[0].begin()) / rate_hz ==
              Approx(3.092 / 343.2).margin(1.3e-3));
    }
}

TEST_CASE("Bypass and a change of the wet share have no step above -60 dB") {
    PluginHost host(OutputFormat::binaural);
    host.set_freewheel(1);
    host.set(Control::quality, 0);
    host.activate();
    const std::vector<float> constant(48000, 0.5F);
    host.run(constant, {256});  // the room's sound becomes constant
    float last = host.run(std::vector<float>(256, 0.5F), {256})[0].back();
    float largest = 0;
    const auto run = [&](std::size_t samples) {
        const Channels output = host.run(std::span(constant).first(samples), {256});
        for (const float x : output[0]) {
            largest = std::max(largest, std::abs(x - last));
            last = x;
        }
    };
    run(4800);
    const float own = largest;  // of the frames of the propagation
    CHECK(own < 1e-3F);
    for (const float enabled : {0.0F, 1.0F, 0.0F}) {
        host.set(Control::enabled, enabled);
        run(9600);
        if (enabled == 0) CHECK(last == Approx(0.5F).margin(1e-6));
    }
    host.set(Control::enabled, 1);
    for (const float wet : {0.3F, 1.0F}) {
        host.set(Control::wet, wet);
        run(7200);
    }
    CHECK(largest < 1e-3F);
    CHECK(last != Approx(0.5F).margin(1e-3));
}

TEST_CASE("The level of the output is its peak, which falls by 20 dB in 1.7 s") {
    PluginHost host(OutputFormat::foa, 8000);
    host.set_freewheel(1);
    host.set(Control::enabled, 0);
    host.activate();
    std::vector<float> click(400);
    click[7] = -0.5F;
    host.run(click, {400});
    CHECK(host.level_db() == Approx(-6.02).margin(0.01));
    host.run(std::vector<float>(13600), {400});
    CHECK(host.level_db() == Approx(-26.02).margin(0.01));
    host.run(std::vector<float>(80000), {400});
    CHECK(host.level_db() == -120);
}

TEST_CASE("Bypassed ambisonics have the input in the omnidirectional channel") {
    PluginHost host(OutputFormat::foa);
    host.set_freewheel(1);
    host.set(Control::enabled, 0);
    host.activate();
    const std::vector<float> input = noise(1000);
    const Channels output = host.run(input, {100});
    CHECK((output[0] == input));
    for (std::size_t c = 1; c < 4; ++c) {
        const auto is_zero = [](float x) { return x == 0; };
        CHECK(std::all_of(output[c].begin(), output[c].end(), is_zero));
    }
}

TEST_CASE("Toggles, gain and places change what a plugin renders") {
    const std::vector<float> input = noise(9600);
    const auto with = [&](const std::vector<std::pair<Control, float>>& changes) {
        PluginHost host(OutputFormat::foa);
        host.set_freewheel(1);
        host.set(Control::quality, 0);
        for (const auto& [control, value] : changes) host.set(control, value);
        host.activate();
        return host.run(input, {480});
    };
    const float all = peak(with({}));
    CHECK(peak(with({{Control::direct, 0}, {Control::early, 0}, {Control::late, 0}})) < 1e-6F);
    CHECK(peak(with({{Control::gain_db, -20}})) == Approx(all / 10).epsilon(1e-3));
    // The direct sound from 0.5 m in front of the head is twice as loud as the input. Between its
    // samples noise exceeds the largest of them.
    const float near = peak(with({{Control::source_x, 4},
                                  {Control::source_y, 3.5F},
                                  {Control::early, 0},
                                  {Control::late, 0}}));
    CHECK(near == Approx(0.4F).epsilon(0.2));
    CHECK(peak(with({{Control::wet, 0}})) == Approx(0.2F).epsilon(0.01));
    // No value of a host gives a sound that is no number.
    constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
    CHECK(peak(with({{Control::source_x, kNan}, {Control::gain_db, kNan}})) == all);
    CHECK(peak(with({{Control::source_x, 1e30F}, {Control::listener_yaw, -1e30F}})) < 1);
}

TEST_CASE("A sample that is no number, or too large, is silence to a plugin") {
    std::vector<float> input = noise(4000);
    const Channels reference = [&] {
        std::vector<float> zeroed = input;
        for (std::size_t n = 1000; n < 1004; ++n) zeroed[n] = 0;
        return bounce(OutputFormat::binaural, zeroed, {256});
    }();
    input[1000] = std::numeric_limits<float>::quiet_NaN();
    input[1001] = std::numeric_limits<float>::infinity();
    input[1002] = 1e38F;
    input[1003] = -1.1e6F;
    CHECK((bounce(OutputFormat::binaural, input, {256}) == reference));
}

TEST_CASE("A plugin that plays, alone or in a group, tells the host of samples that it silences") {
    for (const float group : {0.0F, 1.0F}) {
        CAPTURE(group);
        PluginHost host(OutputFormat::binaural);
        host.set(Control::room_group, group);
        host.set(Control::wet, 0.5F);
        host.activate();
        std::vector<float> input = noise(8192);
        input[100] = 3e38F;
        input[4000] = std::numeric_limits<float>::quiet_NaN();
        CHECK(peak(host.run(input, {256})) < 100);
        CHECK(run_until(host, [&] {
            return host.received(kStatus).find("were not finite, or beyond 1e6") !=
                   std::string::npos;
        }));
    }
}

TEST_CASE("A plugin whose frames are late reduces its rays and tells the host, also in a group") {
    const TemporaryFolder folder;
    const std::string file = folder.write("rays.json", R"({"aula": 1,
        "geometry": [{"box": [5, 4, 3], "material": "concrete"}],
        "sources": [{"position": [1, 1, 1]}], "listener": {"position": [4, 3, 1.5]},
        "simulation": {"rays": 50000, "ir_length_s": 0.5}})");
    PluginHost own(OutputFormat::foa);
    PluginHost member(OutputFormat::foa);
    member.set(Control::room_group, 1);
    for (PluginHost* const host : {&own, &member}) {
        host->activate();
        host->send_path(kScene, file);
    }
    const auto is_told = [](PluginHost& host) {
        return run_until(host, [&] {
            return host.received(kStatus).find("of 50000 rays") != std::string::npos;
        });
    };
    CHECK(is_told(own));
    CHECK(is_told(member));
    // One that joins the group later.
    PluginHost late(OutputFormat::foa);
    late.set(Control::room_group, 1);
    late.activate();
    late.send_path(kScene, file);
    CHECK(is_told(late));
    // In another room, which has its own number of rays, it is not true any more.
    own.set(Control::room_group, 2);
    CHECK(run_until(own, [&] { return own.received(kStatus).empty(); }));
}

TEST_CASE("A plugin plays another scene, tells the host, and saves and restores it") {
    const TemporaryFolder folder;
    const std::string file = folder.write("free.json", kFreeField);
    std::vector<float> click(4800);
    click[0] = 1;
    const auto silent_from_1000 = [&](PluginHost& host) {
        host.set_freewheel(1);
        const Channels output = host.run(click, {256});
        const auto is_loud = [](float x) { return std::abs(x) > 1e-6F; };
        CHECK(std::any_of(output[0].begin(), output[0].begin() + 1000, is_loud));
        return std::none_of(output[0].begin() + 1000, output[0].end(), is_loud);
    };
    StoredState state;
    {
        PluginHost host(OutputFormat::foa);
        host.activate();
        CHECK_FALSE(silent_from_1000(host));
        CHECK(host.save().empty());
        host.send_path(kScene, file);
        CHECK(silent_from_1000(host));
        REQUIRE(run_until(host, [&] { return host.received(kScene) == file; }));
        state = host.save();
        CHECK(state.at(kScene).second.size() == file.size() + 1);
    }
    PluginHost host(OutputFormat::foa);
    host.restore(state);
    host.activate();
    CHECK(silent_from_1000(host));
    host.send_get();
    CHECK(run_until(host, [&] { return host.received(kStatus).empty(); }));
    host.restore({});
    CHECK_FALSE(silent_from_1000(host));
    CHECK(host.save().empty());
}

TEST_CASE("A plugin keeps properties of a state that only a newer version knows") {
    const std::string keys = AULA_PLUGIN_URI "#keys";
    const std::string walls = AULA_PLUGIN_URI "#walls";
    const std::string tempo = "http://example.org/tempo";
    const auto bytes_of = [](const std::string& text) {
        return std::vector<char>(text.c_str(), text.c_str() + text.size() + 1);
    };
    const StoredState newer{
        {walls, {LV2_ATOM__String, bytes_of("soft")}},
        {tempo, {LV2_ATOM__Float, {1, 2, 3, 4}}},
        {kScene, {LV2_ATOM__Path, bytes_of("/nonexistent/hall.json")}},
        {keys, {LV2_ATOM__String, bytes_of(kScene + " " + walls + " " + tempo)}}};
    PluginHost host(OutputFormat::foa);
    host.restore(newer);
    CHECK((host.save() == newer));
    // They are those of the newest state.
    StoredState other = newer;
    other.erase(tempo);
    host.restore(other);
    other[keys].second = bytes_of(kScene + " " + walls);
    CHECK((host.save() == other));
    host.restore({});
    CHECK(host.save().empty());
}

TEST_CASE("A restored scene behind a link of the host finds the files beside it") {
    const TemporaryFolder folder;
    folder.write("far.obj", "v 9 9 9\nv 9 10 9\nv 9 9 10\nf 1 2 3\n");
    const std::string file = folder.write("scene.json", R"({"aula": 1,
        "geometry": [{"name": "far", "file": "far.obj", "material": "brick"}],
        "sources": [{"name": "s", "position": [3.432, 0, 0], "signal": "impulse"}],
        "listener": {"position": [0, 0, 0]}})");
    // Hosts store links to files in the folder of a session.
    const TemporaryFolder session;
    const std::string link = session.path() / "scene.json";
    std::filesystem::create_symlink(file, link);
    PluginHost host(OutputFormat::foa);
    const std::vector<char> bytes(link.c_str(), link.c_str() + link.size() + 1);
    host.restore({{kScene, {LV2_ATOM__Path, bytes}}});
    host.activate();
    host.send_get();
    CHECK(run_until(host, [&] { return host.received(kStatus).empty(); }));
    CHECK(host.received(kScene) == std::filesystem::canonical(file));
}

TEST_CASE("If its scene is gone a plugin plays the default room, says so, and keeps the name") {
    const std::vector<float> input = noise(3000);
    const Channels reference = bounce(OutputFormat::binaural, input, {256});
    PluginHost host(OutputFormat::binaural);
    const std::string gone = "/nonexistent/hall.json";
    const std::vector<char> bytes(gone.c_str(), gone.c_str() + gone.size() + 1);
    host.restore({{kScene, {LV2_ATOM__Path, bytes}}});
    host.set(Control::quality, 0);
    host.set_freewheel(1);
    host.activate();
    CHECK((host.run(input, {256}) == reference));
    REQUIRE(
        run_until(host, [&] { return host.received(kStatus).find(gone) != std::string::npos; }));
    CHECK(host.received(kScene) == gone);
    CHECK(host.save().at(kScene).second == bytes);
}

TEST_CASE("In real time a plugin sounds from the first block on and follows its controls") {
    PluginHost host(OutputFormat::binaural);
    host.set(Control::quality, 0);
    host.activate();
    const std::vector<float> input = noise(24000);
    CHECK(peak(host.run(input, {64})) > 0.001F);
    // The frames take the controls; a mute of all parts is heard as silence.
    for (const Control part : {Control::direct, Control::early, Control::late}) host.set(part, 0);
    CHECK(run_until(host, [&] { return peak(host.run(input, {256})) < 1e-6F; }));
    host.deactivate();
    host.set(Control::direct, 1);
    host.activate();
    CHECK(peak(host.run(input, {8192})) > 0.001F);
}

TEST_CASE("In real time the response of a plugin begins with 4 s and grows") {
    const TemporaryFolder folder;
    // It sounds for more than 10 s, at little cost.
    const std::string hall = folder.write("hall.json", R"({"aula": 1,
        "geometry": [{"box": [30, 20, 10], "material": "hard"}],
        "materials": {"hard": {"absorption": 0.02}},
        "sources": [{"position": [5, 5, 2]}], "listener": {"position": [20, 10, 2]},
        "simulation": {"rays": 200, "patch_size_m": 5, "frame_rate_hz": 5, "specular_order": 0,
                       "diffraction_order": 0}})");
    const float group = GENERATE(0.0F, 1.0F);
    CAPTURE(group);
    StoredState state;
    {
        PluginHost host(OutputFormat::foa);
        host.activate();
        host.send_path(kScene, hall);
        REQUIRE(run_until(host, [&] { return host.received(kScene) == hall; }));
        state = host.save();
    }
    // Its first room is the hall.
    PluginHost host(OutputFormat::foa);
    host.set(Control::room_group, group);
    host.restore(state);
    host.activate();
    const auto last_heard_s = [](PluginHost& heard) {
        std::vector<float> click(48000 * 5);
        click[0] = 1;
        const Channels output = heard.run(click, {256});
        std::size_t last = click.size() - 1;
        while (last > 0 && std::all_of(output.begin(), output.end(),
                                       [&](const auto& channel) { return channel[last] == 0; }))
            --last;
        return static_cast<double>(last) / 48000;
    };
    const double first_s = last_heard_s(host);
    CHECK(first_s > 3.5);
    CHECK(first_s < 4.5);  // with fades, filters and whole partitions
    if (!run_until(host, [&] { return last_heard_s(host) > 4.5; })) {
        host.send_get();
        host.run(std::vector<float>(256), {256});
        // Only where frames are late.
        REQUIRE(host.received(kStatus).find("this machine keeps up with") != std::string::npos);
        WARN("skipped: the machine is too slow for a longer response");
        return;
    }
    if (group == 0) return;
    // An instance that is heard from elsewhere, in another room of the group.
    PluginHost elsewhere(OutputFormat::foa);
    elsewhere.set(Control::room_group, group);
    elsewhere.set(Control::listener_x, 15);
    elsewhere.restore(state);
    elsewhere.activate();
    CHECK(last_heard_s(elsewhere) > 4.5);
}

}  // namespace plugin_test
