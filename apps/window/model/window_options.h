#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "apps/room/base/playback_options.h"
#include "apps/room/remote/osc_options.h"
#include "aula/engine/scene_file.h"

namespace aula {

/// The scene that the window plays and the window's initial state.
struct WindowOptions {
    std::filesystem::path scene_file;
    PlaybackOptions playback;
    std::function<LoadedScene(const std::filesystem::path&)> load;
    std::function<void(Scene&)> change;               ///< applies command-line options
    std::function<void(const std::string&)> warn;     ///< prints a warning in the terminal
    bool rays_given = false;                          ///< on the command line
    std::vector<std::filesystem::path> scenes;        ///< of page up and page down
    std::optional<std::filesystem::path> screenshot;  ///< output PNG file
    double screenshot_after_s = 5;                    ///< time from the start
    std::optional<OscOptions> osc;                    ///< OSC messages to receive
    bool keeps_state = true;                          ///< stores size and display options
    std::function<bool()> interrupted;                ///< true: close the window
};

}  // namespace aula
