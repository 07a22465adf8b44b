#include "tests/plugin/editor/editor_system.h"

#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "tests/plugin/editor/clap_editor_host.h"
#include "tests/plugin/editor/lv2_editor_host.h"
#include "tests/plugin/editor/vst3_editor_host.h"
#include "tests/window/display.h"

namespace aula::test {

namespace {

std::size_t entries(const char* folder) {
    const std::filesystem::directory_iterator all(folder);
    return static_cast<std::size_t>(std::distance(begin(all), end(all)));
}

}  // namespace

bool has_display() {
    if (!are_installed("Xvfb xdotool")) {
        WARN("skipped: Xvfb or xdotool is not installed (packages-test.txt)");
        return false;
    }
    static const Display private_display("800x500");
    if (!private_display.running()) WARN("skipped: no display can run here");
    return private_display.running();
}

std::vector<std::string> editor_formats() { return {"LV2", "CLAP", "VST3"}; }

std::unique_ptr<EditorFormat> editor_host(const std::string& format) {
    if (format == "CLAP") return std::make_unique<ClapEditorHost>();
    if (format == "VST3") return std::make_unique<Vst3EditorHost>();
    return std::make_unique<Lv2EditorHost>();
}

void set_home(const std::string& folder) { setenv("HOME", folder.c_str(), 1); }

HeldResources held_resources() {
    std::ifstream file("/proc/self/statm");
    double pages = 0;
    file >> pages >> pages;
    return {pages * 4096e-6, entries("/proc/self/fd"), entries("/proc/self/task")};
}

TEST_CASE("Without a display an editor is refused") {
    const char* const present = std::getenv("DISPLAY");
    const std::string before = present != nullptr ? present : "";
    unsetenv("DISPLAY");
    for (const std::string& format : editor_formats()) {
        CAPTURE(format);
        CHECK_FALSE(editor_host(format)->open(1));
    }
    ClapEditorHost host;
    CHECK_FALSE(host.open(1));
    CHECK(host.logged().find("there is no display") != std::string::npos);
    if (!before.empty()) setenv("DISPLAY", before.c_str(), 1);
}

}  // namespace aula::test
