#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <random>

namespace aula::test {

/// Random values that depend on the seed only, on all platforms.
class RandomValues {
 public:
    explicit RandomValues(std::uint64_t seed) : bits_(seed) {}

    double uniform(double min, double max) {
        constexpr double kUnit = 1.0 / 9007199254740992.0;  // 2^-53
        return min + (max - min) * static_cast<double>(bits_() >> 11U) * kUnit;
    }
    double log_uniform(double min, double max) { return min * std::pow(max / min, uniform(0, 1)); }
    int integer(int min, int max) {
        return std::min(max, min + static_cast<int>(uniform(0, max - min + 1)));
    }
    bool chance(double probability) { return uniform(0, 1) < probability; }

    template <typename T>
    T pick(std::initializer_list<T> values) {
        return values.begin()[integer(0, static_cast<int>(values.size()) - 1)];
    }

 private:
    std::mt19937_64 bits_;
};

}  // namespace aula::test
