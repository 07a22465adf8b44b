#include "apps/window/state_file.h"

#include <catch2/catch.hpp>

#include "tests/support/temporary_folder.h"

using namespace aula;
using namespace aula::test;

TEST_CASE(
    "Without a stored state the window is as large as the display and shows the table first") {
    const WindowState state = read_state("/nonexistent");
    CHECK(state.width == 0);
    CHECK(state.height == 0);
    CHECK(state.choices.plots.order[0] == Pane::parameters);
}

TEST_CASE("The window's size and the chosen plots are kept, but not an invalid order") {
    const TemporaryFolder folder;
    const std::filesystem::path file = folder.path() / "window";
    WindowState state;
    state.width = 1500;
    state.height = 900;
    state.choices.plots.order = with_first(Pane::walk, kPaneOrder);
    write_state(state, file);
    const WindowState kept = read_state(file);
    CHECK(kept.width == 1500);
    CHECK(kept.height == 900);
    CHECK(kept.choices.plots.order == state.choices.plots.order);

    folder.write("window", "width 10\nheight 0\npane1 1\npane2 1\npane3 7\n");
    const WindowState mended = read_state(file);
    CHECK(mended.width == 640);
    CHECK(mended.height == 0);
    CHECK(mended.choices.plots.order == kPaneOrder);
}
