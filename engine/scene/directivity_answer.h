#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace aula {

/// Start of the answer of the program that reads directivities in SOFA.
struct DirectivityHeader {
    enum class Verdict : std::uint32_t { usable, unreadable, other_kind, incomplete, too_large };

    static constexpr std::array<char, 8> kMagic{'A', 'U', 'L', 'A', 'D', 'I', 'R', '1'};
    /// Limits of a file: directions, frequencies, values of all measurements.
    static constexpr std::size_t kMaxDirections = 16384;
    static constexpr std::size_t kMaxFrequencies = 16384;
    static constexpr std::size_t kMaxValues = std::size_t{1} << 24;

    std::array<char, 8> magic = kMagic;
    Verdict verdict = Verdict::unreadable;
    std::uint32_t directions = 0;
    std::uint32_t frequencies = 0;
    std::uint32_t spherical = 0;  ///< 1: coordinates are azimuth, elevation (degrees), radius
    std::array<double, 3> view{1, 0, 0};  ///< front of the source
    std::array<double, 3> up{0, 0, 1};
};

/// Answer of that program, in this order and in native byte order. If the verdict is not `usable`,
/// it is the header alone.
struct DirectivityAnswer {
    DirectivityHeader header;
    std::vector<double> coordinates;     ///< [3 * directions]
    std::vector<double> frequencies_hz;  ///< [frequencies]
    std::vector<double> energies;  ///< [direction * frequencies + frequency] squared pressures
};

}  // namespace aula
