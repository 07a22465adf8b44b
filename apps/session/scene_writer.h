#pragma once

#include <filesystem>
#include <string>

#include "engine/scene.h"

namespace aula {

/// The scene as a scene file that says the same: geometry as vertices and faces, materials as they
/// are. Sound files are named relative to `folder`, where they can be.
std::string scene_text(const Scene& scene, const std::filesystem::path& folder);

/// Writes a scene file under a temporary name and renames it. Throws Error, AudioFailure.
void write_scene(const Scene& scene, const std::filesystem::path& file);

}  // namespace aula
