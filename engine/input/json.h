#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

namespace aula {

struct JsonMember;

/// A parsed JSON value. Numbers without sign, fraction and exponent stay exact as std::uint64_t,
/// all others are double and finite. Members keep the file's order; their keys are unique.
struct JsonValue {
    using Array = std::vector<JsonValue>;
    using Object = std::vector<JsonMember>;

    std::variant<std::monostate, bool, double, std::uint64_t, std::string, Array, Object> value;
};

struct JsonMember {
    std::string key;
    JsonValue value;
};

/// Parses JSON with comments. `file` is the name in messages. Throws Error: a syntax error or a NUL
/// byte with line and column; NaN, infinity, a number too large for a double, a duplicate key,
/// nesting deeper than 100 and more than ten million values with the JSON pointer.
JsonValue parse_json(const std::string& text, const std::string& file);

/// A JSON pointer extended by a key, escaped as RFC 6901 says.
std::string json_pointer(const std::string& parent, const std::string& key);

}  // namespace aula
