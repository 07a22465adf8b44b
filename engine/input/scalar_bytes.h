#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>

namespace aula {

/// Reads a number in the given byte order from `bytes`, which may be unaligned.
template <class T>
T read_scalar(const char* bytes, std::endian order) {
    std::array<char, sizeof(T)> raw;
    std::copy_n(bytes, sizeof(T), raw.begin());
    if (order != std::endian::native) std::reverse(raw.begin(), raw.end());
    return std::bit_cast<T>(raw);
}

}  // namespace aula
