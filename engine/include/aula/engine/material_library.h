#pragma once

#include <string>
#include <vector>

#include "aula/engine/scene.h"

namespace aula {

/// A material that ships with Aula.
struct LibraryMaterial {
    Material material;   ///< its name is unique in the library
    std::string source;  ///< the book or measurement, and which values are estimates
};

/// All materials that ship with Aula, sorted by name. They are compiled into the library from
/// engine/scene/materials.json; no file is read.
std::vector<LibraryMaterial> material_library();

}  // namespace aula
