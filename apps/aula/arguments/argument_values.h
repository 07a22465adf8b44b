#pragma once

#include <charconv>
#include <string>
#include <system_error>
#include <utility>

#include "aula/engine/bands.h"
#include "aula/engine/vec3.h"

namespace aula {

// Readers of the values of options. For a text that is not valid they throw an InputError that
// contains `expected`, the description of the valid values.

/// Throws the InputError for a value.
[[noreturn]] void refuse_value(const std::string& option, const std::string& text,
                               const std::string& expected);

/// The whole text as a number in [min, max].
template <typename T>
T read_number(const std::string& option, const std::string& text, T min, T max,
              const std::string& expected) {
    T value{};
    const char* end = text.data() + text.size();
    const auto read = std::from_chars(text.data(), end, value);
    const bool usable = read.ec == std::errc() && read.ptr == end && value >= min && value <= max;
    if (!usable) refuse_value(option, text, expected);
    return value;
}

/// The whole text as a whole number in [min, max].
template <typename T>
T read_whole(const std::string& option, const std::string& text, T min, T max) {
    return read_number(option, text, min, max,
                       "a whole number from " + std::to_string(min) + " to " + std::to_string(max));
}

/// The position x,y,z in metres.
Vec3 read_point(const std::string& option, const std::string& text);

/// The name and the position of NAME=x,y,z.
std::pair<std::string, Vec3> read_named_point(const std::string& option, const std::string& text);

/// Levels of all bands in dB, or one number, which `of_one` converts to them.
Bands read_levels(const std::string& option, const std::string& text, const std::string& expected,
                  Bands (*of_one)(float));

}  // namespace aula
