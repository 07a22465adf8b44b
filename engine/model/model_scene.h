#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "aula/engine/scene_file.h"
#include "engine/input/json.h"

namespace aula {

/// What the user knows about a model and its file does not say.
struct ModelOptions {
    std::optional<double> scale;  ///< metres per unit of the file
    std::optional<bool> y_is_up;
};

/// The scene of a model: the content of a scene file, and one line for each guess in it.
struct ModelScene {
    JsonValue json;
    std::vector<std::string> guesses;
};

/// Makes the scene of a mesh file: its materials by their properties in glTF ("extras"), by their
/// names, or by guess; its unit and axes; sources and listener of the file (ImportedPlace), or
/// where people would stand. File names in the scene are relative to `folder`. Throws InputError.
ModelScene scene_of_model(const std::filesystem::path& file, const std::filesystem::path& folder,
                          const ModelOptions& options = {});

/// Reads the scene of a mesh file, as load_scene().
LoadedScene load_model(const std::filesystem::path& file, const ModelOptions& options,
                       SignalFiles signals = SignalFiles::required);

}  // namespace aula
