#pragma once

#include <array>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <string>

#include "apps/documents/value_scale.h"
#include "aula/engine/scene.h"

namespace aula {

/// Display colour of a material: typical for known names, else a muted one derived from the name.
Colour material_colour(const Material& material);

/// Colour of a reflection order; 0 is the direct sound.
Colour order_colour(int order);

/// Colour of an octave band, from red (low) to violet (high).
Colour band_colour(std::size_t band);

}  // namespace aula
