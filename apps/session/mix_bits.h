#pragma once

#include <cstdint>

namespace aula {

/// A bijection of 64-bit numbers that makes neighbours unrelated (the finaliser of SplitMix64):
/// seeds and noise that are the same with every standard library.
constexpr std::uint64_t mix_bits(std::uint64_t x) noexcept {
    x += 0x9E3779B97F4A7C15U;
    x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9U;
    x = (x ^ (x >> 27)) * 0x94D049BB133111EBU;
    return x ^ (x >> 31);
}

}  // namespace aula
