#include "apps/output/json_text.h"

#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <vector>

namespace aula {

namespace {

template <typename T>
std::string shortest(T value) {
    std::array<char, 64> text{};
    char* const end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
    return {text.data(), end};
}

constexpr std::size_t kColumns = 100;
constexpr std::size_t kIndent = 2;

/// The elements of a list or an object between brackets; `column` is the column of the first
/// element, `columns` the longest line.
std::string list_text(const std::vector<std::string>& elements, const char* brackets,
                      std::size_t indent, std::size_t column, std::size_t columns) {
    std::string line(1, brackets[0]);
    bool fits = true;
    for (std::size_t i = 0; i < elements.size() && fits; ++i) {
        line += (i > 0 ? ", " : "") + elements[i];
        // Reserves space for a comma.
        fits = column + line.size() + 2 <= columns && line.find('\n') == std::string::npos;
    }
    if (fits) return line + brackets[1];
    std::string text(1, brackets[0]);
    for (std::size_t i = 0; i < elements.size(); ++i)
        text += (i > 0 ? ",\n" : "\n") + std::string(indent + kIndent, ' ') + elements[i];
    return text + '\n' + std::string(indent, ' ') + brackets[1];
}

std::string text_of(const JsonValue& value, std::size_t indent, std::size_t column,
                    std::size_t columns) {
    const std::size_t inner = indent + kIndent;
    if (const auto* flag = std::get_if<bool>(&value.value)) return *flag ? "true" : "false";
    if (const auto* whole = std::get_if<std::uint64_t>(&value.value)) return std::to_string(*whole);
    if (const auto* text = std::get_if<std::string>(&value.value)) return json_string(*text);
    if (const auto* number = std::get_if<double>(&value.value)) {
        constexpr double kWhole = 1e15;  // integers up to here are written without an exponent
        const bool whole = *number == std::floor(*number) && std::abs(*number) < kWhole;
        return whole ? std::to_string(static_cast<std::int64_t>(*number)) : json_number(*number);
    }
    std::vector<std::string> elements;
    if (const auto* array = std::get_if<JsonValue::Array>(&value.value)) {
        for (const JsonValue& element : *array)
            elements.push_back(text_of(element, inner, inner, columns));
        return list_text(elements, "[]", indent, column, columns);
    }
    if (const auto* object = std::get_if<JsonValue::Object>(&value.value)) {
        for (const auto& [key, member] : *object) {
            const std::string name = json_string(key) + ": ";
            elements.push_back(name + text_of(member, inner, inner + name.size(), columns));
        }
        return list_text(elements, "{}", indent, column, columns);
    }
    return "null";
}

}  // namespace

std::string json_string(const std::string& text) {
    std::string quoted = "\"";
    for (const char c : text) {
        if (c == '"' || c == '\\') {
            quoted += '\\';
            quoted += c;
        } else if (static_cast<unsigned char>(c) < 0x20) {
            std::array<char, 8> escape{};
            std::snprintf(escape.data(), escape.size(), "\\u%04x", static_cast<unsigned>(c));
            quoted += escape.data();
        } else {
            quoted += c;
        }
    }
    return quoted + '"';
}

std::string json_number(float value) { return shortest(value); }

std::string json_number(double value) { return shortest(value); }

std::string json_text(const JsonValue& value) { return text_of(value, 0, 0, kColumns); }

std::string json_line(const JsonValue& value) {
    return text_of(value, 0, 0, std::numeric_limits<std::size_t>::max());
}

}  // namespace aula
