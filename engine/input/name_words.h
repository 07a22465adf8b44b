#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace aula {

/// A list of words, separated by blanks: lower case, without accents; and what they mean.
struct NameWords {
    const char* meaning;
    const char* words;
};

/// What a name means, and the word that says so.
struct NameMeaning {
    std::string meaning;
    std::string word;  ///< as it is listed
};

/// The words of a name in lower case without accents: divided at anything but letters and before
/// capitals. "ae", "oe" and "ue" become "a", "o" and "u", as German writes umlauts.
std::vector<std::string> words_of(std::string_view name);

/// Calls `use` with each of the words of a list.
template <typename Use>
constexpr void for_each_word(std::string_view list, const Use& use) {
    while (!list.empty()) {
        const std::size_t end = std::min(list.find(' '), list.size());
        use(list.substr(0, end));
        list.remove_prefix(std::min(end + 1, list.size()));
    }
}

/// The entry with the longest word that the words mean; of equally long ones the last in the name,
/// which in German is the head of a compound.
std::optional<NameMeaning> longest_meaning(const std::vector<std::string>& words,
                                           std::span<const NameWords> table);

}  // namespace aula
