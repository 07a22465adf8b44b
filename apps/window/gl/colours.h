#pragma once

#include <array>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <string>

#include "apps/documents/value_scale.h"
#include "aula/engine/scene.h"

namespace aula {

/// Patterns that are drawn on surfaces, in true size.
enum class SurfacePattern {
    plain,
    bricks,
    blocks,
    tiles,
    boards,
    panels,
    cloth,
    grains,
    panes,
    ribs
};

/// How surfaces of a material are drawn.
struct MaterialLook {
    Colour colour{0};
    SurfacePattern pattern = SurfacePattern::plain;
};

/// The look of a material: typical for known names and for those that mean a known one, else a
/// muted colour derived from the name.
MaterialLook material_look(const std::string& name);

/// Colour of a reflection order; 0 is the direct sound.
Colour order_colour(int order);

/// Colour of an octave band, from red (low) to violet (high).
Colour band_colour(std::size_t band);

}  // namespace aula
