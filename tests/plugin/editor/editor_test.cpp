#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "tests/plugin/editor/clap_editor_host.h"
#include "tests/plugin/editor/editor_system.h"
#include "tests/plugin/editor/host_window.h"
#include "tests/support/temporary_folder.h"

namespace editor_test {

namespace {

using namespace aula;
using namespace aula::test;
using plugin::Control;

constexpr std::array<int, 3> kSource{255, 153, 38};
constexpr unsigned kWidth = 760;
constexpr unsigned kHeight = 480;
constexpr int kSidePanelX = 474;  ///< of the editor's first size

/// Whether a new window is above the others in its parent, or below.
#if defined(_WIN32)
constexpr bool kNewIsAbove = false;
#else
constexpr bool kNewIsAbove = true;
#endif

/// Calls the timers until a condition holds, for at most a minute.
bool idle_until(EditorFormat& host, const std::function<bool()>& holds) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(1);
    while (!holds()) {
        if (std::chrono::steady_clock::now() > end) return false;
        host.idle();
        HostWindow::dispatch();
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return true;
}

/// Calls them a few times, in which an event of the mouse is drawn.
void settle(EditorFormat& host) {
    for (int turn = 0; turn < 8; ++turn) {
        host.idle();
        HostWindow::dispatch();
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
}

void drag(EditorFormat& host, Pixel from, Pixel to) {
    HostWindow::move_mouse(from);
    settle(host);
    HostWindow::press(true);
    settle(host);
    HostWindow::move_mouse({(from.x + to.x) / 2, (from.y + to.y) / 2});
    settle(host);
    HostWindow::move_mouse(to);
    settle(host);
    HostWindow::press(false);
    settle(host);
}

void click(EditorFormat& host, Pixel at) {
    HostWindow::move_mouse(at);
    settle(host);
    HostWindow::press(true);
    settle(host);
    HostWindow::press(false);
    settle(host);
}

}  // namespace

TEST_CASE("In the editor of each format a mouse drags the source in the plan") {
    if (!has_display()) return;
    const auto format = GENERATE(from_range(editor_formats()));
    CAPTURE(format);
    const HostWindow window(kWidth, kHeight);
    const auto host = editor_host(format);
    REQUIRE(host->open(window.number()));
    REQUIRE(idle_until(*host, [&] { return window.mark(kSource).has_value(); }));
    settle(*host);
    CHECK(window.colours() > 20);
    const Pixel before = *window.mark(kSource);
    const Pixel to{before.x - 60, before.y + 30};
    drag(*host, before, to);
    // It is where the mouse is, to the pixel and rounding.
    REQUIRE(idle_until(*host, [&] {
        const auto after = window.mark(kSource);
        return after && std::abs(after->x - to.x) <= 2 && std::abs(after->y - to.y) <= 2;
    }));
    // The plan moves it in x and y: to the left and to the right of the listener.
    CHECK(host->get(Control::source_room_x) < -0.05);
    CHECK(host->get(Control::source_room_y) < -0.05);
    CHECK(host->get(Control::source_room_z) == Approx(0).margin(1e-6));
    CHECK(host->get(Control::listener_room_x) == 0);
    // The host has been told, between the beginning and the end of a gesture.
    CHECK(host->told(Control::source_room_x) ==
          Approx(host->get(Control::source_room_x)).margin(1e-6));
    CHECK(host->gestures() == 0);
    CHECK(host->ended_gestures() >= 2);
    // What the host automates is drawn.
    host->set(Control::source_room_x, 1);
    CHECK(idle_until(*host, [&] {
        const auto mark = window.mark(kSource);
        return mark && mark->x > before.x;
    }));
    host->close();
}

TEST_CASE("Two editors are open at once, and only that under the mouse follows it") {
    if (!has_display()) return;
    const HostWindow window(kWidth, kHeight);
    ClapEditorHost first;
    REQUIRE(first.open(window.number()));
    settle(first);
    ClapEditorHost second;
    REQUIRE(second.open(window.number()));
    REQUIRE(idle_until(second, [&] { return window.mark(kSource).has_value(); }));
    settle(first);
    const Pixel from = *window.mark(kSource);
    drag(second, from, {from.x - 40, from.y});
    settle(first);
    ClapEditorHost& above = kNewIsAbove ? second : first;
    ClapEditorHost& below = kNewIsAbove ? first : second;
    CHECK(above.get(Control::source_room_x) < -0.05);
    CHECK(below.get(Control::source_room_x) == 0);
    first.close();
    settle(second);
    CHECK(window.mark(kSource));
}

TEST_CASE("An editor chooses a scene file, of which the host's project is told") {
    if (!has_display()) return;
    const std::string format = GENERATE("CLAP", "VST3");
    CAPTURE(format);
    const TemporaryFolder home;
    home.write("only.json", R"({"aula": 1, "sources": [{"position": [2, 1, 1.5]}],
                                "listener": {"position": [0, 0, 1.5]}})");
    set_home(home.path().string());
    const HostWindow window(kWidth, kHeight);
    const auto host = editor_host(format);
    REQUIRE(host->open(window.number()));
    REQUIRE(idle_until(*host, [&] { return window.mark(kSource).has_value(); }));
    const std::optional<Pixel> before = window.mark(kSource);
    // "open...", after "the default room"; then the line after "..".
    click(*host, {kSidePanelX + 140, 36});
    click(*host, {kSidePanelX + 40, 78});
    CHECK(host->told_changes() == 1);
    CHECK(host->gestures() == 0);
    CHECK(idle_until(*host, [&] {
        const auto mark = window.mark(kSource);
        return mark && mark->x != before->x;
    }));
    host->close();
}

TEST_CASE("An editor chooses a room that ships") {
    if (!has_display()) return;
    const HostWindow window(kWidth, kHeight);
    ClapEditorHost host;
    REQUIRE(host.open(window.number()));
    REQUIRE(idle_until(host, [&] { return window.mark(kSource).has_value(); }));
    // The list at the upper right, and the third of its lines.
    const auto [width, height] = host.size();
    REQUIRE(width <= kWidth);
    REQUIRE(height <= kHeight);
    click(host, {static_cast<int>(width) - 60, 16});
    click(host, {static_cast<int>(width) - 100, 75});
    CHECK(host.get(Control::room) > 0);
    CHECK(host.gestures() == 0);
}

TEST_CASE("Opened and closed 50 times, editors leave no memory, files or threads") {
    if (!has_display()) return;
    const auto format = GENERATE(from_range(editor_formats()));
    CAPTURE(format);
    const HostWindow window(kWidth, kHeight);
    const auto host = editor_host(format);
    const auto open_and_close = [&](int times) {
        for (int turn = 0; turn < times; ++turn) {
            REQUIRE(host->open(window.number()));
            settle(*host);
            host->close();
        }
    };
    // Libraries load what they keep.
    open_and_close(10);
    const HeldResources before = held_resources();
    open_and_close(50);
    const HeldResources after = held_resources();
    CHECK(after.files <= before.files);
    CHECK(after.threads <= before.threads);
    // A font and its texture alone are 1 MB.
    CHECK(after.memory_mb - before.memory_mb < 25);
}

TEST_CASE("An editor survives the window that it is in") {
    if (!has_display()) return;
    const auto format = GENERATE(from_range(editor_formats()));
    CAPTURE(format);
    auto window = std::make_unique<HostWindow>(kWidth, kHeight);
    const auto host = editor_host(format);
    REQUIRE(host->open(window->number()));
    settle(*host);
    window.reset();
    settle(*host);
    host->close();
}

}  // namespace editor_test
