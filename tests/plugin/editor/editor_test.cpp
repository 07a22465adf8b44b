#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "tests/plugin/editor/clap_editor_host.h"
#include "tests/plugin/editor/host_window.h"
#include "tests/plugin/editor/lv2_editor_host.h"
#include "tests/plugin/editor/vst3_editor_host.h"
#include "tests/window/display.h"

namespace editor_test {

namespace {

using namespace aula;
using namespace aula::test;
using plugin::Control;

constexpr std::array<int, 3> kSource{255, 153, 38};
constexpr unsigned kWidth = 760;
constexpr unsigned kHeight = 480;

/// The display of all tests; null, with the reason, where none can run.
const Display* display() {
    if (!are_installed("Xvfb xdotool")) {
        WARN("skipped: Xvfb or xdotool is not installed (packages-test.txt)");
        return nullptr;
    }
    static const Display private_display("800x500");
    if (!private_display.running()) WARN("skipped: no display can run here");
    return private_display.running() ? &private_display : nullptr;
}

std::unique_ptr<EditorFormat> host_of(const std::string& format) {
    if (format == "CLAP") return std::make_unique<ClapEditorHost>();
    if (format == "VST3") return std::make_unique<Vst3EditorHost>();
    return std::make_unique<Lv2EditorHost>();
}

/// Calls the timers until a condition holds, for at most a minute.
bool idle_until(EditorFormat& host, const std::function<bool()>& holds) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(1);
    while (!holds()) {
        if (std::chrono::steady_clock::now() > end) return false;
        host.idle();
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return true;
}

/// Calls them a few times, in which an event of the mouse is drawn.
void settle(EditorFormat& host) {
    for (int turn = 0; turn < 8; ++turn) {
        host.idle();
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

std::size_t entries(const char* folder) {
    const std::filesystem::directory_iterator all(folder);
    return static_cast<std::size_t>(std::distance(begin(all), end(all)));
}

double resident_mb() {
    std::ifstream file("/proc/self/statm");
    double pages = 0;
    file >> pages >> pages;
    return pages * 4096e-6;
}

}  // namespace

TEST_CASE("In the editor of each format a mouse drags the source in the plan") {
    if (display() == nullptr) return;
    const auto format = GENERATE(as<std::string>{}, "LV2", "CLAP", "VST3");
    CAPTURE(format);
    const HostWindow window(kWidth, kHeight);
    const auto host = host_of(format);
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
    if (display() == nullptr) return;
    const HostWindow window(kWidth, kHeight);
    ClapEditorHost below;
    REQUIRE(below.open(window.number()));
    settle(below);
    ClapEditorHost above;
    REQUIRE(above.open(window.number()));
    REQUIRE(idle_until(above, [&] { return window.mark(kSource).has_value(); }));
    below.idle();
    const Pixel from = *window.mark(kSource);
    drag(above, from, {from.x - 40, from.y});
    below.idle();
    CHECK(above.get(Control::source_room_x) < -0.05);
    CHECK(below.get(Control::source_room_x) == 0);
    below.close();
    settle(above);
    CHECK(window.mark(kSource));
}

TEST_CASE("An editor chooses a room that ships") {
    if (display() == nullptr) return;
    const HostWindow window(kWidth, kHeight);
    ClapEditorHost host;
    REQUIRE(host.open(window.number()));
    REQUIRE(idle_until(host, [&] { return window.mark(kSource).has_value(); }));
    const auto click = [&](Pixel at) {
        HostWindow::move_mouse(at);
        settle(host);
        HostWindow::press(true);
        settle(host);
        HostWindow::press(false);
        settle(host);
    };
    // The list at the upper right, and the third of its lines.
    const auto [width, height] = host.size();
    REQUIRE(width <= kWidth);
    REQUIRE(height <= kHeight);
    click({static_cast<int>(width) - 60, 16});
    click({static_cast<int>(width) - 100, 75});
    CHECK(host.get(Control::room) > 0);
    CHECK(host.gestures() == 0);
}

TEST_CASE("Opened and closed 50 times, editors leave no memory, files or threads") {
    if (display() == nullptr) return;
    const auto format = GENERATE(as<std::string>{}, "LV2", "CLAP", "VST3");
    CAPTURE(format);
    const HostWindow window(kWidth, kHeight);
    const auto host = host_of(format);
    const auto open_and_close = [&](int times) {
        for (int turn = 0; turn < times; ++turn) {
            REQUIRE(host->open(window.number()));
            settle(*host);
            host->close();
        }
    };
    // Libraries load what they keep.
    open_and_close(10);
    const double before_mb = resident_mb();
    const std::size_t files = entries("/proc/self/fd");
    const std::size_t threads = entries("/proc/self/task");
    open_and_close(50);
    CHECK(entries("/proc/self/fd") <= files);
    CHECK(entries("/proc/self/task") <= threads);
    // A font and its texture alone are 1 MB.
    CHECK(resident_mb() - before_mb < 25);
}

TEST_CASE("An editor survives the window that it is in") {
    if (display() == nullptr) return;
    const auto format = GENERATE(as<std::string>{}, "LV2", "CLAP", "VST3");
    CAPTURE(format);
    auto window = std::make_unique<HostWindow>(kWidth, kHeight);
    const auto host = host_of(format);
    REQUIRE(host->open(window->number()));
    settle(*host);
    window.reset();
    settle(*host);
    host->close();
}

TEST_CASE("Without a display an editor is refused") {
    const char* const present = std::getenv("DISPLAY");
    const std::string before = present != nullptr ? present : "";
    unsetenv("DISPLAY");
    for (const std::string format : {"LV2", "CLAP", "VST3"}) {
        CAPTURE(format);
        CHECK_FALSE(host_of(format)->open(1));
    }
    ClapEditorHost host;
    CHECK_FALSE(host.open(1));
    CHECK(host.logged().find("there is no display") != std::string::npos);
    if (!before.empty()) setenv("DISPLAY", before.c_str(), 1);
}

}  // namespace editor_test
