#include "audio/file/sample_quantizer.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace aula {

SampleQuantizer::SampleQuantizer(int bits, std::optional<std::uint64_t> dither_seed)
    : full_scale_steps_(std::exp2(bits - 1)), step_(1 << (32 - bits)) {
    assert(bits >= 2 && bits <= 32);
    if (dither_seed) random_.emplace(*dither_seed);
}

void SampleQuantizer::quantize(std::span<const float> samples, std::vector<int>& integers) {
    integers.clear();
    for (const float sample : samples) {
        // floor(x + 1/2) rounds to nearest; halves are not rounded away from zero, which would
        // give the error a sign.
        const double steps =
            std::floor(static_cast<double>(sample) * full_scale_steps_ + dither_steps() + 0.5);
        integers.push_back(
            static_cast<int>(std::clamp(steps, -full_scale_steps_, full_scale_steps_ - 1)) * step_);
    }
}

// The difference of two independent uniform numbers in 0..1: triangular from -1 to 1.
double SampleQuantizer::dither_steps() {
    if (!random_) return 0;
    const std::uint64_t bits = (*random_)();
    const auto difference =
        static_cast<std::int64_t>(bits >> 32) - static_cast<std::int64_t>(bits & 0xffffffffU);
    return static_cast<double>(difference) * 0x1p-32;
}

}  // namespace aula
