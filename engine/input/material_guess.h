#pragma once

#include <string>

namespace aula {

/// A material of the library for a material of a model.
struct MaterialGuess {
    std::string material;  ///< a name of the library
    std::string word;      ///< the word of the model's name that means it; empty: none does
};

/// Guesses the material that a name such as "Wand_Putz.001", "Arch|OakFloor" or "béton brut" means:
/// by words of building materials in English, German, French and Spanish, else by words of parts of
/// a building, else plaster.
MaterialGuess guess_material(const std::string& name);

/// Whether a name means a floor or a ceiling.
bool names_horizontal_part(const std::string& name);

}  // namespace aula
