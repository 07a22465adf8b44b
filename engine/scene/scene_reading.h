#pragma once

#include <filesystem>
#include <string>

#include "aula/engine/scene_file.h"
#include "engine/input/json.h"

namespace aula {

/// Reads a scene from the JSON of a scene file, as parse_scene().
LoadedScene read_scene(JsonValue json, const std::string& name, const std::filesystem::path& folder,
                       SignalFiles signals);

}  // namespace aula
