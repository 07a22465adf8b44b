#pragma once

#include <array>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <string>

#include "engine/scene/scene.h"

namespace aula {

/// 0..1 each.
using Colour = glm::vec3;

/// The colour of a surface: that which one expects of a known material, a muted one otherwise.
Colour material_colour(const Material& material);

/// Reflection order: 0 is the direct sound.
Colour order_colour(int order);

/// Octave bands, low ones red to high ones violet.
Colour band_colour(std::size_t band);

/// From dark blue to bright yellow, for 0..1.
Colour heat_colour(float value);

}  // namespace aula
