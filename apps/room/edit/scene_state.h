#pragma once

#include <string>
#include <string_view>

#include "aula/engine/scene.h"

namespace aula {

/// The name of a source's directivity: of one that ships, or the file that it was read from.
std::string directivity_name(const Source& source);

/// Assigns a directivity by its name as in a scene file: one that ships, or a file. Throws
/// InputError.
void set_directivity(Source& source, const std::string& name);

/// All of a scene that affects results, as bytes. They do not depend on the process; equal scenes
/// have equal bytes. The number of threads, which does not affect results, is only included if
/// `threads` is true.
std::string scene_state(const Scene& scene, bool threads);

/// The scene of scene_state(). Throws InputError if the bytes are of another version or damaged, or
/// if the file of a directivity has other content.
Scene scene_from_state(std::string_view state);

/// Throws InputError unless each triangle refers to vertices and materials that exist, and each
/// coordinate is at most 1e6 m.
void check_geometry(const Scene& scene);

}  // namespace aula
