#pragma once

#include <array>
#include <cstdint>

namespace aula {

/// Output of the program that reads SOFA files: this header, then in single precision
/// 3 * directions coordinates, 2 * directions * samples of the responses and 2 * directions delays.
/// Native byte order.
struct SofaHeader {
    enum class Verdict : std::uint32_t {
        usable,
        unreadable,
        not_netcdf,  ///< HDF5 that was not written as netCDF-4
        other_kind,
        incomplete,
        too_large
    };

    std::array<char, 8> magic = kMagic;
    Verdict verdict = Verdict::unreadable;
    std::uint32_t directions = 0;
    std::uint32_t samples = 0;
    float sample_rate_hz = 0;

    static constexpr std::array<char, 8> kMagic{'A', 'U', 'L', 'A', 'S', 'O', 'F', 'A'};
};

}  // namespace aula
