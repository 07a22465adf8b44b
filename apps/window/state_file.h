#pragma once

#include <filesystem>
#include <optional>

#include "apps/window/panels.h"

namespace aula {

/// The window's state that is kept from one run to the next.
struct WindowState {
    int width = 0;  ///< 0: as large as the display
    int height = 0;
    Choices choices;
};

/// $XDG_STATE_HOME/aula/window, or ~/.local/state/aula/window; empty without both variables.
std::optional<std::filesystem::path> state_file();

/// Reads a state file. Missing and invalid entries keep their defaults; no errors.
WindowState read_state(const std::filesystem::path& file);

/// Writes the state, and creates its folder; ignores errors.
void write_state(const WindowState& state, const std::filesystem::path& file);

}  // namespace aula
