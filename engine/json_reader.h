#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/json.h"

namespace aula {

/// The numbers that make sense in one place.
struct NumberRange {
    double min = -std::numeric_limits<double>::infinity();
    double max = std::numeric_limits<double>::infinity();
    bool min_allowed = true;  ///< false: only numbers above min
    const char* expected = "a number";
};

/// A place in a JSON file: reads the value there as the type that the caller wants. All functions
/// throw Error with the file and the JSON pointer of what is wrong. Valid as long as the value and
/// the file's name that it was made from.
class JsonReader {
 public:
    JsonReader(const JsonValue& value, const std::string& file, std::string pointer = {})
        : value_(&value), file_(&file), pointer_(std::move(pointer)) {}

    /// The line that tells the user of a problem here: "FILE: PLACE: problem".
    std::string message(const std::string& problem) const;
    /// Throws Error with that line; the problem is "what is wrong; what was expected".
    [[noreturn]] void fail(const std::string& problem) const;

    /// Throws unless the value is an object that has no other keys than these.
    void allow_keys(const std::vector<std::string>& keys) const;

    /// The member of that key, if there. The value must be an object.
    std::optional<JsonReader> find(const std::string& key) const;
    /// The member of that key; `expected` says in the error what it should hold.
    JsonReader require(const std::string& key, const char* expected) const;
    /// All members in the file's order, with their keys.
    std::vector<std::pair<std::string, JsonReader>> members(const char* expected) const;
    /// The elements of a list.
    std::vector<JsonReader> items(const char* expected) const;

    bool is_number() const;
    bool boolean() const;
    /// A string without NUL.
    std::string string(const char* expected) const;
    double number(const NumberRange& range) const;
    /// A number whose float is within the range, too.
    float real(const NumberRange& range) const { return static_cast<float>(number(range)); }
    int integer(int min, int max) const;
    std::uint64_t unsigned_integer() const;

 private:
    [[noreturn]] void fail_type(const char* expected) const;

    const JsonValue* value_;
    const std::string* file_;
    std::string pointer_;
};

}  // namespace aula
