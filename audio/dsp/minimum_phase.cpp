#include "audio/dsp/minimum_phase.h"

#include <algorithm>
#include <cassert>

namespace aula {

MinimumPhase::MinimumPhase(std::size_t size)
    : fft_(size), spectrum_(fft_.bins()), cepstrum_(size) {}

// The complex cepstrum of a minimum-phase response is causal (Oppenheim and Schafer, Discrete-Time
// Signal Processing). The cepstrum of ln |H| is its even part: doubling the positive half and
// dropping the negative half gives the causal cepstrum.
void MinimumPhase::complete(std::span<const float> log_magnitude,
                            std::span<std::complex<float>> log_response) {
    assert(log_magnitude.size() == bins() && log_response.size() == bins());
    const std::size_t half = fft_.size() / 2;
    std::copy(log_magnitude.begin(), log_magnitude.end(), spectrum_.begin());
    fft_.inverse(spectrum_.data(), cepstrum_.data());
    const float scale = 1 / static_cast<float>(fft_.size());
    cepstrum_[0] *= scale;
    cepstrum_[half] *= scale;
    for (std::size_t n = 1; n < half; ++n) {
        cepstrum_[n] *= 2 * scale;
        cepstrum_[half + n] = 0;
    }
    fft_.forward(cepstrum_.data(), spectrum_.data());
    std::copy(spectrum_.begin(), spectrum_.end(), log_response.begin());
}

}  // namespace aula
