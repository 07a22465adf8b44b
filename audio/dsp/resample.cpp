#include "audio/dsp/resample.h"

#include <soxr.h>

#include <algorithm>
#include <cassert>
#include <cmath>

#include "aula/exception.h"

namespace aula {

std::vector<float> resample(std::span<const float> interleaved, std::size_t channels,
                            double from_hz, double to_hz) {
    assert(channels > 0 && interleaved.size() % channels == 0);
    if (from_hz == to_hz) return {interleaved.begin(), interleaved.end()};
    const std::size_t count = interleaved.size() / channels;
    if (count == 0) return {};
    const auto wanted = static_cast<std::size_t>(
        std::max(1LL, std::llround(static_cast<double>(count) * to_hz / from_hz)));
    std::vector<float> out(wanted * channels);
    const soxr_io_spec_t io = soxr_io_spec(SOXR_FLOAT32_I, SOXR_FLOAT32_I);
    const soxr_quality_spec_t quality = soxr_quality_spec(SOXR_HQ, 0);
    const soxr_runtime_spec_t runtime = soxr_runtime_spec(1);
    std::size_t produced = 0;
    const soxr_error_t error =
        soxr_oneshot(from_hz, to_hz, static_cast<unsigned>(channels), interleaved.data(), count,
                     nullptr, out.data(), wanted, &produced, &io, &quality, &runtime);
    if (error != nullptr) throw Failure("the sound cannot be resampled");
    return out;
}

}  // namespace aula
