#pragma once

#include <string>
#include <vector>

#include "aula/engine/material_library.h"

namespace aula {

/// A search of the material library. A material is found if its name or source contains each word,
/// or if the word means a material whose name is in its name (guess_material()): "holz" finds
/// "wood" and "wood_floor". Upper and lower case are equal; an empty search finds all.
class MaterialSearch {
 public:
    explicit MaterialSearch(const std::string& text);

    bool finds(const LibraryMaterial& entry) const;

 private:
    struct Word {
        std::string text;
        std::string material;  ///< that it means; empty: none
    };

    std::vector<Word> words_;
};

}  // namespace aula
