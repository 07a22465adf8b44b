#include "engine/tail/carrier_moments.h"

#include <algorithm>
#include <cstddef>
#include <cstring>

#include "process/multiversion.h"

namespace aula {
namespace {

/// Samples that are added together.
constexpr std::size_t kTogether_samples = 16;
using Together = float __attribute__((vector_size(kTogether_samples * sizeof(float))));
using Steps = std::int16_t __attribute__((vector_size(kTogether_samples * sizeof(std::int16_t))));

AULA_MULTIVERSION void add_samples(std::span<const std::int16_t> carrier, const std::int16_t* other,
                                   float begin, float step, CarrierMoments& sums) {
    Together zeroth{}, first{}, second{}, product{}, t;
    for (std::size_t k = 0; k < kTogether_samples; ++k) t[k] = begin + step * static_cast<float>(k);
    for (std::size_t j = 0; j < carrier.size(); j += kTogether_samples) {
        Steps x{}, y{};
        const std::size_t bytes = sizeof x[0] * std::min(kTogether_samples, carrier.size() - j);
        std::memcpy(&x, carrier.data() + j, bytes);
        std::memcpy(&y, other + j, bytes);
        const Together sample = __builtin_convertvector(x, Together);
        const Together power = sample * sample;
        zeroth += power;
        first += power * t;
        second += power * t * t;
        product += sample * __builtin_convertvector(y, Together);
        t += step * static_cast<float>(kTogether_samples);
    }
    for (std::size_t k = 0; k < kTogether_samples; ++k) {
        sums.zeroth += double{zeroth[k]};
        sums.first += double{first[k]};
        sums.second += double{second[k]};
        sums.product += double{product[k]};
    }
}

}  // namespace

void CarrierMoments::add(std::span<const std::int16_t> carrier, const std::int16_t* other,
                         float begin, float step) {
    best_version<add_samples>(carrier, other, begin, step, *this);
}

}  // namespace aula
