#include "engine/input/place_guess.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <string_view>
#include <vector>

#include "engine/input/name_words.h"

namespace aula {

namespace {

constexpr const char* kListener = "listener";

// English, German, French, Spanish.
constexpr std::array kPlaces{
    NameWords{kListener,
              "listener receiver horer zuhorer empfanger auditeur auditrice recepteur oyente "
              "receptor"},
    NameWords{"source",
              "source speaker loudspeaker lautsprecher quelle schallquelle tonquelle sprecher "
              "hautparleur enceinte altavoz altavoces parlante fuente"}};

constexpr std::size_t kLongestWord = [] {
    std::size_t longest = 0;
    for (const NameWords& place : kPlaces)
        for_each_word(place.words,
                      [&](std::string_view word) { longest = std::max(longest, word.size()); });
    return longest;
}();

}  // namespace

std::optional<PlaceGuess> guess_place(const std::string& name) {
    const std::vector<std::string> words = words_of(name);
    for (std::size_t first = 0; first < words.size(); ++first) {
        std::string rest;  // "haut-parleur" in one word
        for (std::size_t i = first; i < words.size() && rest.size() < kLongestWord; ++i)
            rest += words[i];
        std::optional<PlaceGuess> guess;
        for (const NameWords& place : kPlaces) {
            for_each_word(place.words, [&](std::string_view listed) {
                if (rest.starts_with(words_of(listed).front()))
                    guess = {std::string_view(place.meaning) == kListener, std::string(listed)};
            });
        }
        if (guess) return guess;
    }
    return std::nullopt;
}

}  // namespace aula
