#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>

#include "tests/plugin/clap_host.h"

namespace clap_realtime_test {

using namespace aula::test;
using aula::plugin::Control;

TEST_CASE("In real time a plugin neither allocates, frees, locks nor writes") {
    ClapHost host("aula.room.stereo.binaural");
    host.set(Control::quality, 0);
    REQUIRE(host.activate(48000, 256));
    RealtimeViolations violations;
    host.watch(violations);
    const Channels input{noise(600), noise(600, 5)};
    bool is_audible = false;
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(4);
    for (int calls = 0; std::chrono::steady_clock::now() < end; ++calls) {
        host.set(Control::source_x, 3 + 0.01 * (calls % 100));
        host.set(Control::source_yaw, calls % 180);
        host.set(Control::listener_room_y, 0.01 * (calls % 100));
        host.set(Control::enabled, calls % 50 < 40 ? 0 : 1);
        host.set(Control::room, calls / 200 % 2);
        host.set(Control::room_group, calls / 400 % 2);
        host.roll(calls % 7 * 1000);
        const Channels output = host.run(input, {calls % 3 == 0 ? 600U : 17U});
        is_audible |= std::any_of(output[0].begin(), output[0].end(),
                                  [](float x) { return std::abs(x) > 1e-3F; });
        host.idle();
    }
    CHECK(is_audible);
    CHECK(violations.total() == 0);
    CHECK(host.misuses() == 0);
}

}  // namespace clap_realtime_test
