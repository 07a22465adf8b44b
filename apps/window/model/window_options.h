#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "apps/session/base/session_options.h"
#include "engine/scene/scene_file.h"

namespace aula {

/// What a window plays and how it starts.
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

}  // namespace aula
