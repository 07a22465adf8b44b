#pragma once

#include <string>

#include "aula/engine/scene.h"
#include "aula/engine/vec3.h"

namespace aula {

/// Places the listener at a position, with its first orientation and without its path.
void set_listener_position(Scene& scene, const Vec3& position);

/// Places a source at a position, with its first orientation and without its path. Throws
/// InputError if the scene has no source of this name.
void set_source_position(Scene& scene, const std::string& name, const Vec3& position);

}  // namespace aula
