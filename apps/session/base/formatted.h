#pragma once

#include <array>
#include <cstdint>
#include <cstdio>
#include <string>

namespace aula {

/// Formats a line of text like printf, truncated to 255 characters.
template <typename... Values>
std::string formatted(const char* format, Values... values) {
    std::array<char, 256> text{};
    std::snprintf(text.data(), text.size(), format, values...);
    return text.data();
}

/// The message for samples that were not finite.
inline std::string muted_text(std::int64_t samples) {
    return std::to_string(samples) + " samples were not finite and were muted";
}

}  // namespace aula
