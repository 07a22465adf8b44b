#include "audio/dsp/kernels.h"

#include <algorithm>
#include <array>

#include "process/multiversion.h"

namespace aula {

namespace {

/// Number of outputs whose sums stay in registers over all taps, where there are as many and where
/// there are fewer.
constexpr std::size_t kTile = 64;
constexpr std::size_t kSmallTile = 16;

AULA_MULTIVERSION
void filter_loop(const float* __restrict x, const float* __restrict h, std::size_t taps,
                 float* __restrict out, std::size_t samples) noexcept {
    std::size_t n = 0;
    for (; n + kTile <= samples; n += kTile) {
        std::array<float, kTile> sum{};
        for (std::size_t k = 0; k < taps; ++k) {
            const float* const delayed = x + n - k;
            for (std::size_t i = 0; i < kTile; ++i) sum[i] += h[k] * delayed[i];
        }
        std::copy(sum.begin(), sum.end(), out + n);
    }
    for (; n + kSmallTile <= samples; n += kSmallTile) {
        std::array<float, kSmallTile> sum{};
        for (std::size_t k = 0; k < taps; ++k) {
            const float* const delayed = x + n - k;
            for (std::size_t i = 0; i < kSmallTile; ++i) sum[i] += h[k] * delayed[i];
        }
        std::copy(sum.begin(), sum.end(), out + n);
    }
    // Of the last outputs, too few for the lanes of a vector, each has the lanes for its taps.
    constexpr std::size_t kLanes = 16;
    for (; n < samples; ++n) {
        std::array<float, kLanes> sum{};
        std::size_t k = 0;
        for (; k + kLanes <= taps; k += kLanes) {
            const float* const oldest = x + n - k - (kLanes - 1);
            for (std::size_t i = 0; i < kLanes; ++i) sum[i] += h[k + i] * oldest[kLanes - 1 - i];
        }
        for (; k < taps; ++k) sum[0] += h[k] * *(x + n - k);
        for (std::size_t i = 0; i < 8; ++i) sum[i] += sum[i + 8];
        for (std::size_t i = 0; i < 4; ++i) sum[i] += sum[i + 4];
        out[n] = (sum[0] + sum[2]) + (sum[1] + sum[3]);
    }
}

AULA_MULTIVERSION
float interpolate_loop(const float* __restrict x, const float* __restrict a,
                       const float* __restrict b, float fraction) noexcept {
    constexpr std::size_t kLanes = 16;
    std::array<float, kLanes> sum{};
    for (std::size_t k = 0; k < kInterpolationTaps; k += kLanes) {
        for (std::size_t i = 0; i < kLanes; ++i) {
            sum[i] += x[k + i] * (a[k + i] + fraction * (b[k + i] - a[k + i]));
        }
    }
    // Constant trip counts keep the reduction in vector registers.
    for (std::size_t i = 0; i < 8; ++i) sum[i] += sum[i + 8];
    for (std::size_t i = 0; i < 4; ++i) sum[i] += sum[i + 4];
    return (sum[0] + sum[2]) + (sum[1] + sum[3]);
}

}  // namespace

void filter(const float* x, const float* h, std::size_t taps, float* out,
            std::size_t samples) noexcept {
    best_version<filter_loop>(x, h, taps, out, samples);
}

float interpolate(const float* x, const float* a, const float* b, float fraction) noexcept {
    return best_version<interpolate_loop>(x, a, b, fraction);
}

}  // namespace aula
