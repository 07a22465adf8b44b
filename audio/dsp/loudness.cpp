#include "audio/dsp/loudness.h"

#include <ebur128.h>

#include <algorithm>
#include <cmath>
#include <new>
#include <utility>
#include <vector>

namespace aula {

struct LoudnessMeter::State {
    State(double sample_rate_hz, std::size_t channel_count)
        : channels(channel_count),
          measured(channel_count == 2 ? 2U : 1U),
          meter(ebur128_init(
              measured, static_cast<unsigned long>(std::lround(sample_rate_hz)),
              EBUR128_MODE_S | EBUR128_MODE_I | EBUR128_MODE_TRUE_PEAK | EBUR128_MODE_HISTOGRAM)) {
        if (meter == nullptr) throw std::bad_alloc();
    }
    ~State() { ebur128_destroy(&meter); }
    State(const State&) = delete;
    State& operator=(const State&) = delete;

    std::size_t channels;
    unsigned measured;
    ebur128_state* meter;
    double true_peak = 0;
    std::vector<float> first;
};

LoudnessMeter::LoudnessMeter(double sample_rate_hz, std::size_t channels)
    : state_(std::make_unique<State>(sample_rate_hz, channels)) {}

LoudnessMeter::~LoudnessMeter() = default;

void LoudnessMeter::add(std::span<const float> interleaved) {
    State& s = *state_;
    const std::size_t count = interleaved.size() / s.channels;
    if (count == 0) return;
    const float* samples = interleaved.data();
    if (s.measured != s.channels) {
        s.first.resize(count);
        for (std::size_t i = 0; i < count; ++i) s.first[i] = interleaved[i * s.channels];
        samples = s.first.data();
    }
    if (ebur128_add_frames_float(s.meter, samples, count) != EBUR128_SUCCESS)
        throw std::bad_alloc();
    for (unsigned c = 0; c < s.measured; ++c) {
        double peak = 0;
        if (ebur128_prev_true_peak(s.meter, c, &peak) == EBUR128_SUCCESS)
            s.true_peak = std::max(s.true_peak, peak);
    }
}

Loudness LoudnessMeter::read() {
    State& s = *state_;
    const auto measured = [&](int (*query)(ebur128_state*, double*)) {
        double lufs = Loudness::kSilence_lufs;
        const bool valid = query(s.meter, &lufs) == EBUR128_SUCCESS && std::isfinite(lufs);
        return valid ? lufs : Loudness::kSilence_lufs;
    };
    Loudness loudness;
    loudness.momentary_lufs = measured(ebur128_loudness_momentary);
    loudness.short_term_lufs = measured(ebur128_loudness_shortterm);
    loudness.integrated_lufs = measured(ebur128_loudness_global);
    loudness.true_peak = std::exchange(s.true_peak, 0);
    return loudness;
}

}  // namespace aula
