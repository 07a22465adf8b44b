#include "apps/output/printable.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <string_view>

#include "engine/input/utf8.h"

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
    const auto lead = static_cast<unsigned char>(text[at]);
    if (lead < 0x80) return (lead >= 0x20 && lead != 0x7F) || lead == '\n' ? 1 : 0;
    const std::size_t length = utf8_length(text, at);
    const std::string_view character = std::string_view(text).substr(at, length);
    // U+0080 to U+009F are control characters.
    if (character.starts_with('\xC2') && character < "\u00A0") return 0;
    return is_directional(character) ? 0 : length;
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
