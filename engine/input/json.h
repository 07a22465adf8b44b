#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

namespace aula {

struct JsonMember;

/// A parsed JSON value. Numbers without sign, fraction and exponent are exact std::uint64_t, all
/// others are finite doubles. Members are in the file's order; their keys are unique.
struct JsonValue {
    using Array = std::vector<JsonValue>;
    using Object = std::vector<JsonMember>;

    std::variant<std::monostate, bool, double, std::uint64_t, std::string, Array, Object> value;
};

struct JsonMember {
    std::string key;
    JsonValue value;
};

/// Parses JSON with comments. `file` is the name in messages. Throws InputError with line and
/// column for a syntax error or a NUL byte, and with the JSON pointer for NaN, infinity, a number
/// too large for a double, a duplicate key, nesting deeper than 100 levels and more than ten
/// million values.
JsonValue parse_json(const std::string& text, const std::string& file);

/// Appends a key to a JSON pointer, escaped according to RFC 6901.
std::string json_pointer(const std::string& parent, const std::string& key);

}  // namespace aula
