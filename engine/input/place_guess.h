#pragma once

#include <optional>
#include <string>

namespace aula {

/// What a node of a model stands for by its name.
struct PlaceGuess {
    bool is_listener = false;  ///< else a source
    std::string word;          ///< the word of its name that means it
};

/// Guesses what a name such as "Lautsprecher links", "Haut-parleur.001" or "Oyente" means: by words
/// of sources and listeners in English, German, French and Spanish with which a word of the name
/// begins.
std::optional<PlaceGuess> guess_place(const std::string& name);

}  // namespace aula
