#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "apps/session/base/session_options.h"
#include "apps/session/live/player.h"
#include "engine/scene/scene_file.h"

namespace aula {

struct WindowOptions {
    std::filesystem::path scene_file;
    SessionOptions session;
    std::function<LoadedScene(const std::filesystem::path&)> load;
    std::function<void(Scene&)> change;               ///< what the command line changes in a scene
    bool rays_given = false;                          ///< the command line says how many
    std::vector<std::filesystem::path> scenes;        ///< to switch among
    std::optional<std::filesystem::path> screenshot;  ///< PNG, written after a time
    double screenshot_after_s = 5;
    std::optional<std::string> osc;  ///< where OSC messages are listened for
    bool keeps_state = true;         ///< size and what is shown, from one time to the next
    std::function<bool()> interrupted;
};

/// Whether a window can be opened here.
bool window_possible();

/// Plays a scene in a window until that is closed, the time that was asked for is over, or a
/// screenshot has been written; how that went. Throws Error, AudioInputError, AudioFailure.
PlayStatus show_window(const WindowOptions& options);

}  // namespace aula
