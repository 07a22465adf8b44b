#include "apps/window/view/material_search.h"

#include <cctype>
#include <sstream>

namespace aula {

namespace {

std::string lower(std::string text) {
    for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return text;
}

}  // namespace

bool matches(const LibraryMaterial& entry, const std::string& search) {
    const std::string text = lower(entry.material.name + " " + entry.source);
    std::istringstream words(lower(search));
    for (std::string word; words >> word;)
        if (text.find(word) == std::string::npos) return false;
    return true;
}

}  // namespace aula
