#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "apps/session/base/session_options.h"
#include "engine/scene/scene.h"

namespace aula {

/// What the command line asks for.
struct Arguments {
    enum class Command {
        help,
        version,
        list_devices,
        materials,
        info,
        check,
        play,
        render,
        measure
    };

    Command command = Command::play;
    std::filesystem::path scene;
    std::optional<std::string> material;      ///< of materials: the one to show
    std::filesystem::path offline;            ///< of render
    std::optional<std::filesystem::path> ir;  ///< of measure, as the next three
    std::optional<std::filesystem::path> echogram;
    std::optional<std::filesystem::path> report_json;
    bool report = false;
    std::optional<int> frames;
    double bin_s = 1e-3;
    SessionOptions session;
    bool rays_given = false;
    bool quiet = false;
    bool window = true;                              ///< if there can be one
    std::optional<std::filesystem::path> scene_dir;  ///< of scenes to switch among
    std::optional<std::filesystem::path> screenshot;
    double screenshot_after_s = 5;
    std::optional<std::string> osc;  ///< where OSC messages are listened for

    /// What options change in a scene, in the order given. Throws Error.
    std::vector<std::function<void(Scene&)>> scene_changes;
};

/// Reads the command line. Throws Error: one line that begins with the option.
Arguments read_arguments(int argc, const char* const* argv);

/// The text of --help.
const char* help_text();

}  // namespace aula
