#include "apps/session/base/printable.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <string_view>

namespace aula {

namespace {

/// Whether a terminal changes the order of the characters that follow: U+061C, U+200E, U+200F,
/// U+202A to U+202E, U+2066 to U+2069 (the explicit directional formatting characters of Unicode
/// Standard Annex 9, section 2).
bool is_directional(std::string_view character) {
    if (character == "\u061C" || character == "\u200E" || character == "\u200F") return true;
    return (character >= "\u202A" && character <= "\u202E") ||
           (character >= "\u2066" && character <= "\u2069");
}

/// Length in bytes of the UTF-8 character at `at`. 0 if it is invalid, or a control character other
/// than a line feed.
std::size_t character_length(const std::string& text, std::size_t at) {
    const auto byte = [&](std::size_t i) {
        return i < text.size() ? static_cast<unsigned char>(text[i]) : 0U;
    };
    const unsigned lead = byte(at);
    if (lead < 0x80) return (lead >= 0x20 && lead != 0x7F) || lead == '\n' ? 1 : 0;
    const std::size_t length = lead >= 0xF0 ? 4 : lead >= 0xE0 ? 3 : 2;
    if (lead < 0xC2 || lead > 0xF4) return 0;
    // Longer than necessary, surrogates, and beyond U+10FFFF.
    const unsigned second = byte(at + 1);
    if ((lead == 0xE0 && second < 0xA0) || (lead == 0xED && second > 0x9F) ||
        (lead == 0xF0 && second < 0x90) || (lead == 0xF4 && second > 0x8F))
        return 0;
    for (std::size_t i = 1; i < length; ++i)
        if ((byte(at + i) & 0xC0U) != 0x80U) return 0;
    // U+0080 to U+009F are control characters.
    if (lead == 0xC2 && second < 0xA0) return 0;
    return is_directional(std::string_view(text).substr(at, length)) ? 0 : length;
}

}  // namespace

std::string printable(const std::string& text) {
    std::string shown;
    for (std::size_t at = 0; at < text.size();) {
        const std::size_t length = character_length(text, at);
        if (length > 0) {
            shown += text.substr(at, length);
        } else {
            std::array<char, 8> escaped{};
            std::snprintf(escaped.data(), escaped.size(), "\\x%02x",
                          static_cast<unsigned>(static_cast<unsigned char>(text[at])));
            shown += escaped.data();
        }
        at += std::max<std::size_t>(1, length);
    }
    return shown;
}

std::string printable_line(const std::string& text) {
    std::string line;
    for (const char c : printable(text)) line += c == '\n' ? "\\x0a" : std::string(1, c);
    return line;
}

std::vector<std::string> printable_lines(std::vector<std::string> texts) {
    for (std::string& text : texts) text = printable_line(text);
    return texts;
}

}  // namespace aula
