#pragma once

#include "aula/engine/scene.h"

namespace aula::plugin {

/// The scene scenes/default.json, which the build embeds.
Scene default_room();

}  // namespace aula::plugin
