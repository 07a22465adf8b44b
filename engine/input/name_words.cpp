#include "engine/input/name_words.h"

#include <algorithm>
#include <cctype>
#include <cstddef>

namespace aula {

namespace {

/// The base letter of a letter of Latin-1 in UTF-8, whose second byte is given; 0 if it has none.
char base_letter(unsigned char second) {
    constexpr std::string_view kLower = "aaaaaaaceeeeiiii-nooooo-ouuuuy-s";  // from U+00C0 on
    constexpr unsigned kFirst = 0x80;
    constexpr unsigned kSharpS = 0x9f;
    if (second == kSharpS) return 's';
    const unsigned place = (second - kFirst) % 32;
    return kLower[place] == '-' ? '\0' : kLower[place];
}

/// Whether a word of a name means `known`. Short words are parts of many others, such as "tur" of
/// "texture": those of at most three letters must be whole words, those of four begin or end one.
bool means(std::string_view word, std::string_view known) {
    constexpr std::size_t kWhole = 3;
    constexpr std::size_t kEnds = 4;
    if (known.size() <= kWhole) return word == known;
    if (known.size() <= kEnds) return word.starts_with(known) || word.ends_with(known);
    return word.find(known) != std::string_view::npos;
}

}  // namespace

std::vector<std::string> words_of(std::string_view name) {
    std::vector<std::string> words(1);
    bool was_lower = false;
    const auto add = [&](char letter) { words.back() += letter; };
    const auto divide = [&] {
        if (!words.back().empty()) words.emplace_back();
    };
    for (std::size_t i = 0; i < name.size(); ++i) {
        const auto c = static_cast<unsigned char>(name[i]);
        const bool has_next = i + 1 < name.size();
        if (c == 0xc3 && has_next) {
            constexpr unsigned kFirstLower = 0x9f;  // the sharp s
            const auto second = static_cast<unsigned char>(name[++i]);
            const bool is_lower = second >= kFirstLower;
            if (!is_lower && was_lower) divide();
            was_lower = is_lower;
            if (const char letter = base_letter(second); letter != '\0') add(letter);
        } else if ((c == 0xcc || c == 0xcd) && has_next) {
            ++i;  // an accent after its letter, as macOS writes names
        } else if (c < 0x80 && std::isalpha(c) != 0) {
            if (std::isupper(c) != 0 && was_lower) divide();
            was_lower = std::islower(c) != 0;
            const char letter = static_cast<char>(std::tolower(c));
            const std::string& word = words.back();
            const bool is_umlaut = letter == 'e' && !word.empty() &&
                                   std::string_view("aou").find(word.back()) != std::string::npos;
            if (!is_umlaut) add(letter);
        } else {
            was_lower = false;
            divide();
        }
    }
    if (words.back().empty()) words.pop_back();
    return words;
}

std::optional<NameMeaning> longest_meaning(const std::vector<std::string>& words,
                                           std::span<const NameWords> table) {
    std::string joined;
    for (const std::string& word : words) joined += word;
    std::optional<NameMeaning> best;
    std::size_t best_at = 0;
    for (const NameWords& entry : table) {
        for_each_word(entry.words, [&](std::string_view listed) {
            // As the names are written.
            const std::string known = words_of(listed).front();
            const bool found = std::any_of(words.begin(), words.end(),
                                           [&](const std::string& w) { return means(w, known); });
            // Long ones may be written in several words: "oak floor board".
            constexpr std::size_t kJoined = 8;
            const std::size_t at = joined.rfind(known);
            if (!found && (known.size() < kJoined || at == std::string::npos)) return;
            if (best && (listed.size() < best->word.size() ||
                         (listed.size() == best->word.size() && at <= best_at)))
                return;
            best = {entry.meaning, std::string(listed)};
            best_at = at;
        });
    }
    return best;
}

}  // namespace aula
