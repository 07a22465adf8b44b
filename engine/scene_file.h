#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "engine/json.h"
#include "engine/scene.h"

namespace aula {

struct LoadedScene {
    Scene scene;
    std::vector<std::string> warnings;  ///< each a line for the user, without "aula: warning:"
    bool rays_given = false;            ///< the file says how many rays
    JsonValue json;                     ///< the file's content; geometry[i] is scene.objects[i]
};

/// Reads a scene file (JSON with comments, docs/scene_format.md) with its meshes. Files inside it
/// are relative to it. Sound files are checked to exist, not read. Throws Error.
LoadedScene load_scene(const std::filesystem::path& file);

}  // namespace aula
