#pragma once

#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <vector>

namespace aula::test {

/// Samples of channels.
using Channels = std::vector<std::vector<float>>;

/// What must hold in a host, which may run on threads on which Catch2 allows no assertion.
inline void demand(bool holds, const char* what) {
    if (!holds) throw std::logic_error(what);
}

/// White noise below 0.2.
inline std::vector<float> noise(std::size_t samples, std::uint32_t seed = 1) {
    std::vector<float> signal(samples);
    for (float& x : signal) {
        seed = seed * 1664525U + 1013904223U;
        x = 0.2F * (static_cast<float>(seed >> 8) * 0x1p-23F - 1);
    }
    return signal;
}

}  // namespace aula::test
