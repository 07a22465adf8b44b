#include "apps/window/model/input_events.h"

#include <catch2/catch.hpp>

using namespace aula;

TEST_CASE("A click between two pictures is a press and a release where they were") {
    MouseEvents mouse;
    CHECK_FALSE(mouse.take().down[0]);
    mouse.add(0, true, 10, 20);
    mouse.add(0, false, 10, 21);
    mouse.add(1, true, 300, 200);  // and the mouse is elsewhere by now
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
    mouse.add(7, true, 0, 0);  // a button that nothing uses
    CHECK_FALSE(mouse.pending());
}

TEST_CASE("A key is held for as long as it is, however often that is measured") {
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

TEST_CASE("A tap that nobody saw held is a short step, once") {
    HeldKeys keys;
    keys.press('w', 1);
    keys.release('w', 1);
    CHECK(keys.any());
    keys.measure(1.2);
    CHECK(keys.held_s('w') == HeldKeys::kTap_s);
    CHECK(keys.held_s('s') == 0);
    keys.measure(1.4);
    CHECK(keys.held_s('w') == 0);
    // Two taps are two steps, and one that was measured while it was held is not made longer.
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

TEST_CASE("What is held while nothing is read for long does not run away") {
    HeldKeys keys;
    keys.press('w', 1);
    keys.measure(60);
    CHECK(keys.held_s('w') == HeldKeys::kLongest_s);
}
