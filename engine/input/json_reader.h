#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "aula/exception.h"
#include "engine/input/json.h"

namespace aula {

/// The valid numbers of a value.
struct NumberRange {
    double min = -std::numeric_limits<double>::infinity();
    double max = std::numeric_limits<double>::infinity();
    bool min_allowed = true;  ///< false: only numbers above min
    const char* expected = "a number";
};

/// A bounded list of the errors in a file. With it, reading continues after an error.
class JsonErrors {
 public:
    void add(const std::string& message);
    bool empty() const { return messages_.empty(); }
    /// The first messages, then the number of further ones.
    std::vector<std::string> messages(const std::string& file) const;

 private:
    std::vector<std::string> messages_;
    std::size_t more_ = 0;
};

/// Reads a value of a JSON file as the type that the caller requests. All functions throw
/// InputError with the file and the JSON pointer. With a JsonErrors list, attempt() collects errors
/// instead. The value, the file's name and the list must outlive the reader.
class JsonReader {
 public:
    JsonReader(const JsonValue& value, const std::string& file, JsonErrors* errors = nullptr)
        : JsonReader(value, file, {}, errors) {}

    /// The value that is read, and the name of its file.
    const JsonValue& value() const { return *value_; }
    const std::string& file() const { return *file_; }

    /// The message about a problem of this value: "FILE: PLACE: problem".
    std::string message(const std::string& problem) const;
    /// Throws InputError with that message; the problem is "what is wrong; what was expected".
    [[noreturn]] void fail(const std::string& problem) const;

    /// Runs a part of the reading. An InputError ends the part and is added to the list; without a
    /// list it is thrown.
    template <typename Part>
    void attempt(const Part& part) const {
        if (errors_ == nullptr) return part();
        try {
            part();
        } catch (const InputError& error) {
            errors_->add(error.what());
        }
    }

    /// Attempts to use the member of a key, if it exists.
    template <typename Use>
    void read(const std::string& key, const Use& use) const {
        if (const auto member = find(key)) attempt([&] { use(*member); });
    }

    /// Each other key of the object is an error. Returns whether there is none.
    bool allow_keys(const std::vector<std::string>& keys) const;

    /// The member of a key, if it exists. The value must be an object.
    std::optional<JsonReader> find(const std::string& key) const;
    /// The member of a key; `expected` describes it in the error.
    JsonReader require(const std::string& key, const char* expected) const;
    /// All members with their keys, in the file's order.
    std::vector<std::pair<std::string, JsonReader>> members(const char* expected) const;
    /// The elements of a list.
    std::vector<JsonReader> items(const char* expected) const;

    bool is_number() const;
    bool is_list() const;
    bool is_object() const;
    bool is_text(const char* text) const;  ///< that string
    bool is_false() const;
    bool boolean() const;
    /// A string without NUL characters.
    std::string string(const char* expected) const;
    double number(const NumberRange& range) const;
    /// A number in single precision that is within the range after rounding.
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
