#pragma once

#include <cstdint>

#include "engine/base/mix64.h"
#include "engine/patches/patch_subdivision.h"

namespace aula {

/// Identifies a path K = (source, patch sequence, listener) by a rolling 128-bit hash: two words
/// mixed with different constants, O(1) per reflection. The probability that any two of n paths
/// collide is n^2 / 2^129: 1.5e-25 for 10^7 cache entries.
struct PathIdentifier {
    std::uint64_t low = 0;
    std::uint64_t high = 0;

    static PathIdentifier start(std::size_t source) {
        return {mix64(source + 0x243f6a8885a308d3ULL), mix64(source + 0x13198a2e03707344ULL)};
    }

    /// The path extended by one patch.
    PathIdentifier extended(const Patch& patch) const {
        const std::uint64_t where = std::uint64_t{patch.triangle} << 1 | (patch.back ? 1 : 0);
        const std::uint64_t cell = std::uint64_t{patch.zeta} << 32 | patch.xi;
        return {mix64(mix64(low ^ where) + cell * 0x9e3779b97f4a7c15ULL),
                mix64(mix64(high + where * 0xd1b54a32d192ed03ULL) ^ cell)};
    }

    /// The path continued through a wall, to be extended by the patch on its far side.
    PathIdentifier transmitted() const {
        return {mix64(low + 0x452821e638d01377ULL), mix64(high ^ 0xbe5466cf34e90c6cULL)};
    }

    /// The path ended at a listener.
    PathIdentifier ended(std::size_t listener) const {
        return {mix64(low + (listener + 1) * 0xa0761d6478bd642fULL),
                mix64(high ^ ((listener + 1) * 0xe7037ed1a0b428dbULL))};
    }

    friend bool operator==(const PathIdentifier&, const PathIdentifier&) = default;
};

}  // namespace aula
