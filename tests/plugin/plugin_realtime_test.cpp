#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <string>
#include <thread>
#include <vector>

#include "tests/plugin/plugin_host.h"
#include "tests/support/realtime_trap.h"
#include "tests/support/temporary_folder.h"

namespace plugin_realtime_test {

using namespace aula;
using namespace aula::test;
using plugin::Control;

namespace {

constexpr const char* kFreeField = R"({"aula": 1,
    "sources": [{"name": "s", "position": [3.432, 0, 0], "signal": "impulse"}],
    "listener": {"position": [0, 0, 0]}})";

}  // namespace

TEST_CASE("In real time a plugin neither allocates, frees, locks nor writes while all changes") {
    const TemporaryFolder folder;
    const std::string file = folder.write("free.json", kFreeField);
    const std::string scene = AULA_PLUGIN_URI "#scene";
    PluginHost host(OutputFormat::binaural);
    host.set(Control::quality, 0);
    host.set(Control::room_group, GENERATE(0.0F, 3.0F));
    host.activate();
    const std::vector<float> input(600, 0.1F);
    RealtimeViolations violations;
    host.watch(violations);
    bool is_audible = false;
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    int calls = 0;
    // Until the plugin has changed to the other scene and back.
    for (int changes = 0; changes < 2 && std::chrono::steady_clock::now() < end; ++calls) {
        host.set(Control::source_x, 3 + 0.01F * static_cast<float>(calls % 100));
        host.set(Control::listener_yaw, static_cast<float>(calls % 180));
        host.set(Control::gain_db, static_cast<float>(calls % 7));
        host.set(Control::enabled, calls % 50 < 40 ? 1 : 0);
        host.set(Control::wet, calls % 30 < 20 ? 1 : 0.5F);
        host.set(Control::early, calls % 20 < 10 ? 1 : 0);
        if (calls == 30) host.set(Control::room_group, 5);
        const std::string wanted = changes % 2 == 0 ? file : "";
        if (calls % 100 == 0) host.send_path(scene, wanted);
        if (calls % 100 == 50) host.send_get();
        if (calls % 10 == 5) host.send_position(calls * 100, 1);
        for (const auto& channel : host.run(input, {calls % 3 == 0 ? 600U : 17U}))
            is_audible |= std::any_of(channel.begin(), channel.end(),
                                      [](float x) { return std::abs(x) > 1e-3F; });
        if (calls % 100 > 60 && host.received(scene) == wanted) {
            ++changes;
            calls += 99 - calls % 100;
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    CHECK(host.received(scene).empty());  // the default room again
    CHECK(is_audible);
    CHECK(violations.total() == 0);
    if (!RealtimeTrap::available()) return;
    // The trap counts what the plugin does: a new room on the exact clock.
    host.set_freewheel(1);
    host.run(input, {600});
    CHECK(violations.locks > 0);
    CHECK(violations.frees > 0);
}

}  // namespace plugin_realtime_test
