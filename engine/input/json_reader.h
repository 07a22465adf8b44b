#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/error.h"
#include "engine/input/json.h"

namespace aula {

/// The numbers that make sense in one place.
struct NumberRange {
    double min = -std::numeric_limits<double>::infinity();
    double max = std::numeric_limits<double>::infinity();
    bool min_allowed = true;  ///< false: only numbers above min
    const char* expected = "a number";
};

/// The messages of errors in a file, for reading on after the first. The list is bounded.
class JsonErrors {
 public:
    void add(const std::string& message);
    bool empty() const { return messages_.empty(); }
    /// The first messages, and how many more there are.
    std::vector<std::string> messages(const std::string& file) const;

 private:
    std::vector<std::string> messages_;
    std::size_t more_ = 0;
};

/// A place in a JSON file: reads the value there as the type that the caller wants. All functions
/// throw Error with the file and the JSON pointer of what is wrong; parts of the
/// reading that attempt() runs go on after an error if there is a list for them. Valid as long as
/// the value, the file's name and the list that it was made from.
class JsonReader {
 public:
    JsonReader(const JsonValue& value, const std::string& file, JsonErrors* errors = nullptr)
        : JsonReader(value, file, {}, errors) {}

    /// The line that tells the user of a problem here: "FILE: PLACE: problem".
    std::string message(const std::string& problem) const;
    /// Throws Error with that line; the problem is "what is wrong; what was expected".
    [[noreturn]] void fail(const std::string& problem) const;

    /// Runs a part of the reading. An Error in it is listed, and the part given up; without a list
    /// it is thrown.
    template <typename Part>
    void attempt(const Part& part) const {
        if (errors_ == nullptr) return part();
        try {
            part();
        } catch (const Error& error) {
            errors_->add(error.what());
        }
    }

    /// Attempts to use the member of that key, if there.
    template <typename Use>
    void read(const std::string& key, const Use& use) const {
        if (const auto member = find(key)) attempt([&] { use(*member); });
    }

    /// Attempts to find no other keys than these in an object, one by one. True if there are none.
    bool allow_keys(const std::vector<std::string>& keys) const;

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
    JsonReader(const JsonValue& value, const std::string& file, std::string pointer,
               JsonErrors* errors)
        : value_(&value), file_(&file), pointer_(std::move(pointer)), errors_(errors) {}

    [[noreturn]] void fail_type(const char* expected) const;

    const JsonValue* value_;
    const std::string* file_;
    std::string pointer_;
    JsonErrors* errors_;
};

}  // namespace aula
