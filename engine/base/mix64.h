#pragma once

#include <cstddef>
#include <cstdint>

namespace aula {

/// A bijective hash of 64 bits (the finalizer of splitmix64).
constexpr std::uint64_t mix64(std::uint64_t x) noexcept {
    x ^= x >> 30;
    x *= 0xbf58476d1ce4e5b9ULL;
    x ^= x >> 27;
    x *= 0x94d049bb133111ebULL;
    return x ^ (x >> 31);
}

/// Hash of structured keys for hash tables.
struct MixHash {
    std::size_t operator()(std::uint64_t key) const noexcept { return mix64(key); }
};

}  // namespace aula
