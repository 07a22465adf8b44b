#include "apps/drawing/input_events.h"

#include <catch2/catch.hpp>

using namespace aula;

TEST_CASE("A click between two frames gives a press and a release at their positions") {
    MouseEvents mouse;
    CHECK_FALSE(mouse.take().down[0]);
    mouse.add(0, true, 10, 20);
    mouse.add(0, false, 10, 21);
    mouse.add(1, true, 300, 200);  // at another position
    REQUIRE(mouse.pending());
    const auto press = mouse.take();
    CHECK(press.down[0]);
    CHECK(press.at == std::array<float, 2>{10, 20});
    const auto release = mouse.take();
    CHECK_FALSE(release.down[0]);
    CHECK(release.at == std::array<float, 2>{10, 21});
    CHECK(mouse.pending());
    CHECK(mouse.take().down[1]);
    CHECK_FALSE(mouse.pending());
    CHECK(mouse.take().down[1]);  // held
    CHECK_FALSE(mouse.take().at);
    mouse.add(7, true, 0, 0);  // an unused button
    CHECK_FALSE(mouse.pending());
}

TEST_CASE("The measured hold time is independent of the measuring interval") {
    for (const double interval_s : {0.01, 0.09, 0.3, 0.7}) {
        INFO(interval_s);
        HeldKeys keys;
        double held_s = 0;
        double next_s = interval_s;
        const auto until = [&](double end_s) {
            for (; next_s < end_s; next_s += interval_s) {
                keys.measure(next_s);
                held_s += keys.held_s('w');
            }
        };
        until(1);
        keys.press('w', 1);
        until(3.5);
        keys.release('w', 3.5);
        until(6);
        CHECK(held_s == Approx(2.5).epsilon(1e-9));  // sums of doubles
        CHECK_FALSE(keys.any());
    }
}

TEST_CASE("A tap between two measurements counts once, for a short time") {
    HeldKeys keys;
    keys.press('w', 1);
    keys.release('w', 1);
    CHECK(keys.any());
    keys.measure(1.2);
    CHECK(keys.held_s('w') == HeldKeys::kTap_s);
    CHECK(keys.held_s('s') == 0);
    keys.measure(1.4);
    CHECK(keys.held_s('w') == 0);
    // Two taps count twice. A press measured while held is not extended.
    for (const double at_s : {2.0, 2.1}) {
        keys.press('w', at_s);
        keys.release('w', at_s + 0.01);
    }
    keys.measure(2.2);
    CHECK(keys.held_s('w') == Approx(2 * HeldKeys::kTap_s));
    keys.press('w', 3);
    keys.measure(3.05);
    keys.release('w', 3.1);
    keys.measure(3.2);
    CHECK(keys.held_s('w') == Approx(0.05));
}

TEST_CASE("The hold time of a stalled interval is limited") {
    HeldKeys keys;
    keys.press('w', 1);
    keys.measure(60);
    CHECK(keys.held_s('w') == HeldKeys::kLongest_s);
}
