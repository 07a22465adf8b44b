#pragma once

#include "engine/base/band_vector.h"

namespace aula {

/// exp(-m length) in each band: the fraction of energy that air transmits. Relative error below
/// 2e-7.
inline BandVector transmission(const BandVector& attenuation_per_m, float length_m) {
    // 2^x for x <= 0 as 2^n 2^f with n = round(x), |f| <= 1/2. Values below 2^-100 are negligible.
    const BandVector exponent = attenuation_per_m * (length_m * -1.44269504F);
    const BandVector x = max_of(exponent, BandVector{} - 100.0F);
    const BandIntegers n = __builtin_convertvector(x - 0.5F, BandIntegers);
    const BandVector f = x - __builtin_convertvector(n, BandVector);
    // Taylor series of 2^f; the next term is below 1.1e-7.
    const BandVector p =
        1.0F +
        f * (0.69314718F +
             f * (0.24022651F +
                  f * (0.05550411F + f * (0.00961813F + f * (0.00133336F + f * 0.00015404F)))));
    const BandIntegers bits = (n + 127) << 23;
    BandVector power;
    std::memcpy(&power, &bits, sizeof power);
    return p * power;
}

inline Bands transmission(const Bands& attenuation_per_m, float length_m) {
    Bands result;
    store_bands(transmission(load_bands(attenuation_per_m), length_m), result.value.data());
    return result;
}

}  // namespace aula
