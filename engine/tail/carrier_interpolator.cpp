#include "engine/tail/carrier_interpolator.h"

#include <algorithm>
#include <array>
#include <cstring>

#include "engine/tail/windowed_sinc.h"
#include "process/multiversion.h"

namespace aula {
namespace {

constexpr std::size_t kTaps = CarrierInterpolator::kTaps;
constexpr std::size_t kPhases = 8;  // phases that are computed together

// Kaiser's window for -80 dB.
constexpr double kShape = 7.86;

/// Phases of one sample.
using Phases = float __attribute__((vector_size(kPhases * sizeof(float))));

[[gnu::always_inline]] inline Phases load(const float* from) {
    Phases lanes;
    std::memcpy(&lanes, from, sizeof lanes);
    return lanes;
}

// The first `phases` of kPhases phases of each sample, at intervals of `stride`.
AULA_MULTIVERSION
void interpolate(const float* in, std::size_t count, const float* weights, std::size_t stride,
                 std::size_t phases, float* out) {
    std::array<Phases, kTaps> w;
    for (std::size_t t = 0; t < kTaps; ++t) w[t] = load(weights + t * kPhases);
    for (std::size_t n = 0; n < count; ++n) {
        Phases even{};
        Phases odd{};
        for (std::size_t t = 0; t < kTaps; t += 2) {
            even += w[t] * in[n + t];
            odd += w[t + 1] * in[n + t + 1];
        }
        const Phases sum = even + odd;
        if (phases == kPhases) {
            std::memcpy(out + n * stride, &sum, sizeof sum);
        } else {
            std::memcpy(out + n * stride, &sum, phases * sizeof(float));
        }
    }
}

}  // namespace

CarrierInterpolator::CarrierInterpolator(std::size_t decimation)
    : decimation_(decimation),
      groups_((decimation + kPhases - 1) / kPhases),
      weights_(groups_ * kTaps * kPhases) {
    for (std::size_t p = 0; p < decimation; ++p) {
        float* const group = weights_.data() + p / kPhases * kTaps * kPhases;
        const double at = static_cast<double>(p) / static_cast<double>(decimation);
        for (std::size_t t = 0; t < kTaps; ++t) {
            group[t * kPhases + p % kPhases] = static_cast<float>(windowed_sinc(
                static_cast<double>(t) - static_cast<double>(kBefore) - at, kTaps, kShape));
        }
    }
}

void CarrierInterpolator::process(const float* in, std::size_t count, float* out) const {
    for (std::size_t g = 0; g < groups_; ++g)
        best_version<interpolate>(in, count, weights_.data() + g * kTaps * kPhases, decimation_,
                                  std::min(decimation_, kPhases), out + g * kPhases);
}

}  // namespace aula
