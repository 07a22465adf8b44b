#include "apps/aula/arguments/argument_values.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "aula/engine/scene.h"
#include "aula/exception.h"

namespace aula {

namespace {

/// Numbers separated by commas, of magnitudes up to `largest`.
std::vector<float> read_numbers(const std::string& option, const std::string& text, float largest,
                                const std::string& expected) {
    std::vector<float> numbers;
    std::size_t begin = 0;
    while (begin <= text.size()) {
        const std::size_t end = std::min(text.find(',', begin), text.size());
        float value = 0;
        const auto read = std::from_chars(text.data() + begin, text.data() + end, value);
        if (read.ec != std::errc() || read.ptr != text.data() + end ||
            !(std::abs(value) <= largest))
            refuse_value(option, text, expected);
        numbers.push_back(value);
        begin = end + 1;
    }
    return numbers;
}

}  // namespace

void refuse_value(const std::string& option, const std::string& text, const std::string& expected) {
    throw InputError(option, "", "\"" + text + "\" is not usable; expected " + expected);
}

Vec3 read_point(const std::string& option, const std::string& text) {
    constexpr float kLargest_m = 1e6F;
    const std::string expected = "x,y,z in metres";
    const std::vector<float> numbers = read_numbers(option, text, kLargest_m, expected);
    if (numbers.size() != 3) refuse_value(option, text, expected);
    return {numbers[0], numbers[1], numbers[2]};
}

std::pair<std::string, Vec3> read_named_point(const std::string& option, const std::string& text) {
    const std::size_t equals = text.rfind('=');
    if (equals == std::string::npos || equals == 0) refuse_value(option, text, "NAME=x,y,z");
    return {text.substr(0, equals), read_point(option, text.substr(equals + 1))};
}

Bands read_levels(const std::string& option, const std::string& text, const std::string& expected,
                  Bands (*of_one)(float)) {
    const std::vector<float> numbers =
        read_numbers(option, text, SpeechConditions::kHighestLevel_db, expected);
    if (numbers.size() == 1) return of_one(numbers[0]);
    if (numbers.size() != kBandCount) refuse_value(option, text, expected);
    Bands levels;
    std::copy(numbers.begin(), numbers.end(), levels.value.begin());
    return levels;
}

}  // namespace aula
