#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <limits>
#include <vector>

#include "aula/engine/bands.h"
#include "engine/base/band_vector.h"

namespace aula {

/// Energy s (1 - alpha) E that leaves diffusely at one reflection, relative to the ray's initial
/// energy. Millions are written, stored and read again, so the format is compact: integer units,
/// one exponent for all bands and 15 bits per band. Rounding is stochastic, which leaves every band
/// unbiased however far it is below the strongest.
struct Deposit {
    /// A unit is 2^kUnit_log2 of a ray's initial energy. A choice: at -102 dB rounding leaves few
    /// deposits of the last reflections, at the energy of which responses end.
    static constexpr int kUnit_log2 = -34;

    /// One less than the type has.
    static constexpr int kMantissaBits = std::numeric_limits<std::uint16_t>::digits - 1;

    std::array<std::uint16_t, kBandCount> mantissa{};
    std::uint32_t patch = 0;
    std::uint16_t bin = 0;      ///< of TimeBins, by the path length
    std::uint8_t ray = 0;       ///< index in its batch
    std::uint8_t exponent = 0;  ///< units are mantissa * 2^exponent

    /// `energy` is below 2^16. `u` is uniform in [0, 1) and independent of the energies.
    void set_energy(const BandVector& energy, float u) {
        const float strongest = max_of_bands(energy)[0];
        const std::int32_t log2 = (std::bit_cast<std::int32_t>(strongest) >> 23) - 127;
        // The strongest mantissa has kMantissaBits at most, so that rounding cannot reach 2^16.
        const std::int32_t shift = std::max(0, log2 + 1 - kUnit_log2 - kMantissaBits);
        const auto scale = power_of_2(-kUnit_log2 - shift);
        const auto whole = __builtin_convertvector(energy * scale + u, BandIntegers);
        const auto parts = __builtin_convertvector(whole, Mantissas);
        std::memcpy(mantissa.data(), &parts, sizeof parts);
        exponent = static_cast<std::uint8_t>(shift);
    }

    BandVector energy() const {
        Mantissas parts;
        std::memcpy(&parts, mantissa.data(), sizeof parts);
        const auto whole = __builtin_convertvector(parts, BandIntegers);
        return __builtin_convertvector(whole, BandVector) * power_of_2(kUnit_log2 + exponent);
    }

    bool empty() const {
        std::uint64_t halves[2];
        std::memcpy(halves, mantissa.data(), sizeof halves);
        return (halves[0] | halves[1]) == 0;
    }

 private:
    using Mantissas = std::uint16_t __attribute__((vector_size(16)));

    static float power_of_2(std::int32_t exponent) {
        return std::bit_cast<float>((exponent + 127) << 23);
    }
};

static_assert(sizeof(Deposit) == 24);

/// Deposits of disjoint parts of the patches, in order of insertion. Each thread adds one part to
/// the sums of its patches, so that threads share no sums and read no other part's deposits.
struct DepositParts {
    /// A choice: as many threads add deposits evenly.
    static constexpr std::uint32_t kCount = 8;

    std::array<std::vector<Deposit>, kCount> part;

    static std::uint32_t part_of(std::uint32_t patch) { return patch % kCount; }

    void add(const Deposit& deposit) { part[part_of(deposit.patch)].push_back(deposit); }

    void clear() {
        for (std::vector<Deposit>& all : part) all.clear();
    }
};

}  // namespace aula
