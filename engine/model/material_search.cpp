#include "engine/model/material_search.h"

#include <algorithm>
#include <cctype>
#include <sstream>

#include "engine/input/material_guess.h"

namespace aula {

namespace {

std::string lower(std::string text) {
    for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return text;
}

}  // namespace

MaterialSearch::MaterialSearch(const std::string& text) {
    std::istringstream words(lower(text));
    for (std::string word; words >> word;) {
        const MaterialGuess guess = guess_material(word);
        words_.push_back({word, guess.word.empty() ? "" : guess.material});
    }
}

bool MaterialSearch::finds(const LibraryMaterial& entry) const {
    const std::string& name = entry.material.name;
    const std::string text = lower(name + " " + entry.source);
    return std::all_of(words_.begin(), words_.end(), [&](const Word& word) {
        return text.find(word.text) != std::string::npos ||
               (!word.material.empty() && name.find(word.material) != std::string::npos);
    });
}

}  // namespace aula
