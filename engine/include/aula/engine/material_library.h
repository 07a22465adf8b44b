#pragma once

#include <string>
#include <vector>

#include "aula/engine/scene.h"

namespace aula {

/// A material that ships with Aula.
struct LibraryMaterial {
    Material material;
    std::string source;  ///< the book or measurement, and which values are estimates
};

/// All materials that ship with Aula, sorted by name. They are part of the library file, so that no
/// file is read. engine/scene/materials.json is the list.
std::vector<LibraryMaterial> material_library();

}  // namespace aula
