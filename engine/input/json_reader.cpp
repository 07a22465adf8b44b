#include "engine/input/json_reader.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "aula/exception.h"
#include "engine/input/names.h"

namespace aula {
namespace {

// The shortest text that reads back as the same number.
std::string number_text(double x) {
    std::array<char, 32> text{};
    const auto end = std::to_chars(text.data(), text.data() + text.size(), x).ptr;
    return {text.data(), end};
}

}  // namespace

void JsonErrors::add(const std::string& message) {
    constexpr std::size_t kMax = 100;
    if (messages_.size() < kMax) {
        messages_.push_back(message);
    } else {
        ++more_;
    }
}

std::vector<std::string> JsonErrors::messages(const std::string& file) const {
    std::vector<std::string> all = messages_;
    if (more_ > 0) {
        all.push_back(
            InputError(file, "", std::to_string(more_) + " more errors; expected none").what());
    }
    return all;
}

std::string JsonReader::message(const std::string& problem) const {
    return InputError(*file_, pointer_, problem).what();
}

void JsonReader::fail(const std::string& problem) const { throw InputError(message(problem)); }

void JsonReader::fail_type(const char* expected) const {
    constexpr const char* kTypes[] = {"null",     "true or false", "a number", "a number",
                                      "a string", "a list",        "an object"};
    fail("wrong type, " + std::string(kTypes[value_->value.index()]) + "; expected " + expected);
}

bool JsonReader::allow_keys(const std::vector<std::string>& keys) const {
    bool allowed = true;
    for (const auto& member : members("an object")) {
        const std::string& key = member.first;
        if (std::find(keys.begin(), keys.end(), key) != keys.end()) continue;
        allowed = false;
        attempt([&] {
            member.second.fail("unknown key " + quoted(key) + did_you_mean(key, keys) +
                               "; expected one of " + quoted_list(keys));
        });
    }
    return allowed;
}

std::optional<JsonReader> JsonReader::find(const std::string& key) const {
    const auto* object = std::get_if<JsonValue::Object>(&value_->value);
    if (object == nullptr) fail_type("an object");
    for (const JsonMember& member : *object) {
        if (member.key == key)
            return JsonReader(member.value, *file_, json_pointer(pointer_, key), errors_);
    }
    return std::nullopt;
}

JsonReader JsonReader::require(const std::string& key, const char* expected) const {
    if (auto member = find(key)) return *std::move(member);
    throw InputError(*file_, json_pointer(pointer_, key),
                     std::string("missing; expected ") + expected);
}

std::vector<std::pair<std::string, JsonReader>> JsonReader::members(const char* expected) const {
    const auto* object = std::get_if<JsonValue::Object>(&value_->value);
    if (object == nullptr) fail_type(expected);
    std::vector<std::pair<std::string, JsonReader>> readers;
    for (const JsonMember& member : *object) {
        readers.emplace_back(member.key, JsonReader(member.value, *file_,
                                                    json_pointer(pointer_, member.key), errors_));
    }
    return readers;
}

std::vector<JsonReader> JsonReader::items(const char* expected) const {
    const auto* array = std::get_if<JsonValue::Array>(&value_->value);
    if (array == nullptr) fail_type(expected);
    std::vector<JsonReader> readers;
    readers.reserve(array->size());
    for (const JsonValue& item : *array) {
        readers.push_back(
            JsonReader(item, *file_, pointer_ + '/' + std::to_string(readers.size()), errors_));
    }
    return readers;
}

bool JsonReader::is_number() const {
    return std::holds_alternative<double>(value_->value) ||
           std::holds_alternative<std::uint64_t>(value_->value);
}

bool JsonReader::is_list() const { return std::holds_alternative<JsonValue::Array>(value_->value); }

bool JsonReader::is_object() const {
    return std::holds_alternative<JsonValue::Object>(value_->value);
}

bool JsonReader::is_text(const char* text) const {
    const auto* x = std::get_if<std::string>(&value_->value);
    return x != nullptr && *x == text;
}

bool JsonReader::is_false() const {
    const bool* x = std::get_if<bool>(&value_->value);
    return x != nullptr && !*x;
}

bool JsonReader::boolean() const {
    const bool* x = std::get_if<bool>(&value_->value);
    if (x == nullptr) fail_type("true or false");
    return *x;
}

std::string JsonReader::string(const char* expected) const {
    const auto* x = std::get_if<std::string>(&value_->value);
    if (x == nullptr) fail_type(expected);
    if (x->find('\0') != std::string::npos) {
        fail(std::string("a NUL character in the string; expected ") + expected);
    }
    return *x;
}

double JsonReader::number(const NumberRange& range) const {
    if (!is_number()) fail_type(range.expected);
    const auto* whole = std::get_if<std::uint64_t>(&value_->value);
    const double x =
        whole != nullptr ? static_cast<double>(*whole) : std::get<double>(value_->value);
    // A number just above an excluded bound must not become the bound as a float.
    const bool low =
        range.min_allowed ? x < range.min : static_cast<double>(static_cast<float>(x)) <= range.min;
    if (low || x > range.max) {
        fail(number_text(x) + " is out of range; expected " + range.expected);
    }
    return x;
}

int JsonReader::integer(int min, int max) const {
    const std::string expected =
        "a whole number from " + std::to_string(min) + " to " + std::to_string(max);
    const double x =
        number({static_cast<double>(min), static_cast<double>(max), true, expected.c_str()});
    if (x != std::floor(x)) fail(number_text(x) + " is not whole; expected " + expected);
    return static_cast<int>(x);
}

std::uint64_t JsonReader::unsigned_integer() const {
    constexpr const char* kExpected = "a whole number from 0 to 18446744073709551615";
    if (const auto* x = std::get_if<std::uint64_t>(&value_->value)) return *x;
    constexpr double kExactIntegers = 9007199254740992;  // 2^53
    const double x = number({0, kExactIntegers, true, kExpected});
    if (x != std::floor(x)) fail(number_text(x) + " is not whole; expected " + kExpected);
    return static_cast<std::uint64_t>(x);
}

}  // namespace aula
