#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "aula/engine/scene_file.h"

namespace aula {

/// The text of the scene file that was read from the folder `from`, changed where `edited` differs
/// from it: materials of triangles, sources, listener and simulation. All other content is kept,
/// except comments. File names become relative to the folder `to`. `edited` has the geometry, the
/// medium and the number of sources of `read`.
std::string edited_scene_text(const LoadedScene& read, const Scene& edited,
                              const std::filesystem::path& from, const std::filesystem::path& to);

/// The comment at the beginning of the scene file of a model: the model's name and what was
/// guessed.
std::string model_comment(const std::filesystem::path& model,
                          const std::vector<std::string>& guesses);

/// Writes that text to a scene file under a temporary name, then renames it. `scene_file` is the
/// file that was read; of a model the text begins with model_comment(). Throws InputError, Failure.
void write_edited_scene(const LoadedScene& read, const Scene& edited,
                        const std::filesystem::path& scene_file, const std::filesystem::path& file);

}  // namespace aula
