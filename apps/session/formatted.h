#pragma once

#include <array>
#include <cstdio>
#include <string>

namespace aula {

/// A line of text as printf makes it, cut off at 255 characters.
template <typename... Values>
std::string formatted(const char* format, Values... values) {
    std::array<char, 256> text{};
    std::snprintf(text.data(), text.size(), format, values...);
    return text.data();
}

}  // namespace aula
