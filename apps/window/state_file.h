#pragma once

#include <filesystem>
#include <optional>

#include "apps/window/panels.h"

namespace aula {

/// What a window looks like from one time to the next.
struct WindowState {
    int width = 1280;
    int height = 800;
    Choices choices;
};

/// $XDG_STATE_HOME/aula/window, or ~/.local/state/aula/window; empty where neither is known.
std::optional<std::filesystem::path> state_file();

/// What a file says; what it does not say, or not rightly, is as usual.
WindowState read_state(const std::filesystem::path& file);

/// Writes it, with its folder; what cannot be written is left.
void write_state(const WindowState& state, const std::filesystem::path& file);

}  // namespace aula
