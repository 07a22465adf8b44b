#pragma once

#include <string>

#include "aula/engine/material_library.h"

namespace aula {

/// Whether a material's name or source contains each word of a search. Upper and lower case are
/// equal; every material contains an empty search.
bool matches(const LibraryMaterial& entry, const std::string& search);

}  // namespace aula
