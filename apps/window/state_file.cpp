#include "apps/window/state_file.h"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <stdexcept>
#include <string>
#include <type_traits>

#include "apps/output/output_file.h"
#include "apps/window/native_window.h"

namespace aula {

namespace {

/// Calls `each(name, value)` for each entry of the file, for both reading and writing.
template <typename State, typename Each>
void for_each_entry(State& state, const Each& each) {
    each("width", state.width);
    each("height", state.height);
    each("solid", state.choices.style.solid);
    each("edges", state.choices.style.edges);
    each("see_in", state.choices.style.cut_away);
    each("rays", state.choices.rays);
    each("direct_paths", state.choices.direct_paths);
    each("early", state.choices.plots.early);
    each("everywhere", state.choices.everywhere);
    each("help", state.choices.help);
    each("pane1", state.choices.plots.order[0]);
    each("pane2", state.choices.plots.order[1]);
    each("pane3", state.choices.plots.order[2]);
    each("pane4", state.choices.plots.order[3]);
    each("pane5", state.choices.plots.order[4]);
    each("text_percent", state.choices.text_percent);
}

}  // namespace

std::optional<std::filesystem::path> state_file() {
    if (const char* state = std::getenv("XDG_STATE_HOME"); state != nullptr && *state != '\0')
        return std::filesystem::path(state) / "aula" / "window";
    if (const char* home = std::getenv("HOME"); home != nullptr && *home != '\0')
        return std::filesystem::path(home) / ".local" / "state" / "aula" / "window";
    return std::nullopt;
}

WindowState read_state(const std::filesystem::path& file) {
    constexpr int kLargest = 16384;
    WindowState state;
    std::ifstream in(file);
    std::string name;
    long value = 0;
    while (in >> name >> value) {
        for_each_entry(state, [&](const char* known, auto& entry) {
            using Entry = std::remove_reference_t<decltype(entry)>;
            if (name == known) entry = static_cast<Entry>(value);
        });
    }
    PaneOrder& order = state.choices.plots.order;
    if (!std::is_permutation(order.begin(), order.end(), kPanes.begin())) order = kPaneOrder;
    state.choices.larger_text(0);  // clamps
    if (state.width != 0) state.width = std::clamp(state.width, NativeWindow::kMinWidth, kLargest);
    if (state.height != 0)
        state.height = std::clamp(state.height, NativeWindow::kMinHeight, kLargest);
    return state;
}

void write_state(const WindowState& state, const std::filesystem::path& file) {
    std::error_code none;
    std::filesystem::create_directories(file.parent_path(), none);
    std::string text;
    for_each_entry(state, [&](const char* name, const auto& entry) {
        text += name + (' ' + std::to_string(static_cast<long>(entry))) + '\n';
    });
    try {
        OutputFile out(file);
        out.write(text);
        out.commit();
    } catch (const Exception&) {
        // The next run uses the previous state.
    }
}

}  // namespace aula
