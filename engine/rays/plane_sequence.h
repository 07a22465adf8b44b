#pragma once

#include <cstdint>

#include "engine/base/mix64.h"

namespace aula {

/// Identifies the sequence of planes that a purely specular path meets by a rolling hash that both
/// ends of the path compute alike: sum over k of h(plane k) x^k modulo 2^64, plane 0 being the
/// listener's. With n sequences the odds that any two share a key are about n^2 / 2^61.
struct PlaneSequence {
    std::uint64_t key = 0;  ///< 0 for no plane
    std::uint64_t power = 1;

    /// With one more plane, for a path that is followed from the listener.
    constexpr PlaneSequence then_from_listener(std::uint32_t plane) const {
        return {key + hash(plane) * power, power * kBase};
    }

    /// With one more plane, for a path that is followed from the source.
    constexpr PlaneSequence then_from_source(std::uint32_t plane) const {
        return {key * kBase + hash(plane), power * kBase};
    }

 private:
    // Odd, and 3 modulo 8: differences of its powers keep all but a few of the 64 bits.
    static constexpr std::uint64_t kBase = 0x9e3779b97f4a7c13ULL;

    static constexpr std::uint64_t hash(std::uint32_t plane) {
        return mix64(plane + 0x452821e638d01377ULL);
    }
};

}  // namespace aula
