#include "audio/dsp/limiter.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <vector>

#include "audio/dsp/fractional_delay.h"

namespace aula {

namespace {

constexpr double kCeiling_db = -1;
constexpr double kLookAhead_s = 0.004;
constexpr double kRelease_s = 0.1;

// Oversampling factor of the true-peak measurement. It underestimates a tone at 0.8 of the Nyquist
// frequency by at most 0.11 dB (ITU-R BS.1770 requires a factor of 4).
constexpr std::size_t kPhases = 8;

// Gains are integer multiples of 2^-30: their running sum is exact, and a gain of one leaves
// samples unchanged to the bit.
constexpr std::int64_t kUnity = std::int64_t{1} << 30;

}  // namespace

// The gain that a peak requires is held over the look-ahead (sliding minimum), released
// exponentially and averaged over the look-ahead. When the delayed peak is output, every term of
// the average is at most the required gain.
struct Limiter::State {
    /// Samples that the interpolator needs before the newest sample.
    static constexpr std::size_t kPast = kInterpolationTaps - 1;

    std::size_t window = 0;  ///< length of the look-ahead, samples
    /// The interpolator finds a peak only after it has received later samples.
    std::size_t latency() const { return window + FractionalDelay::kAfter - 1; }
    float ceiling = 0;
    double release = 0;

    FractionalDelay interpolator;
    float interpolator_gain = 1;  ///< bound of interpolated values re the largest sample

    std::vector<float> gains;                 ///< of the present block
    std::vector<std::vector<float>> recent;   ///< [channel] kPast samples, then the present block
    std::vector<std::vector<float>> delayed;  ///< [channel] ring of latency() samples
    std::size_t delayed_position = 0;
    std::vector<float> peaks;  ///< of the present block
    std::vector<std::int64_t> averaged;
    std::int64_t sum = 0;  ///< of `averaged`
    std::int64_t held = kUnity;
    std::size_t position = 0;
    std::uint64_t now = 0;
    float min_gain = 1;

    /// Ring of the candidates of the sliding minimum, in ascending order of time and gain.
    struct Candidate {
        std::uint64_t time;
        std::int64_t gain;
    };
    std::vector<Candidate> candidates;
    std::size_t first = 0;
    std::size_t count = 0;

    Candidate& candidate(std::size_t i) noexcept AULA_NONBLOCKING {
        return candidates[(first + i) % candidates.size()];
    }

    /// The smallest gain of this sample and the `window` before it.
    std::int64_t sliding_minimum(std::int64_t gain) noexcept AULA_NONBLOCKING {
        while (count > 0 && candidate(count - 1).gain >= gain) --count;
        candidate(count++) = {now, gain};
        if (candidate(0).time + window < now) {
            first = (first + 1) % candidates.size();
            --count;
        }
        return candidate(0).gain;
    }

    /// For each sample of the block, the largest magnitude over all channels between the sample
    /// kAfter before it and the next one.
    void find_peaks(std::size_t samples) noexcept AULA_NONBLOCKING {
        std::fill_n(peaks.begin(), samples, 0.0F);
        for (const std::vector<float>& signal : recent) {
            float largest = 0;
            for (std::size_t i = 0; i < kPast + samples; ++i) {
                largest = std::max(largest, std::abs(signal[i]));
            }
            const bool between = largest * interpolator_gain > ceiling;
            for (std::size_t i = 0; i < samples; ++i) {
                const float* const x = signal.data() + i;
                float peak = std::max(std::abs(x[FractionalDelay::kBefore]),
                                      std::abs(x[FractionalDelay::kBefore + 1]));
                for (std::size_t phase = 1; between && phase < kPhases; ++phase) {
                    const double fraction =
                        static_cast<double>(phase) / static_cast<double>(kPhases);
                    peak = std::max(peak, std::abs(interpolator.read(x, fraction)));
                }
                peaks[i] = std::max(peaks[i], peak);
            }
        }
    }

    /// Adds the newest peak. Returns the gain of the sample `window` before it.
    float next_gain(float peak) noexcept AULA_NONBLOCKING {
        std::int64_t needed = kUnity;
        if (peak > ceiling) {
            // A margin for the rounding of the gain to a float.
            needed = static_cast<std::int64_t>(double{ceiling} / double{peak} * (1 - 2e-7) *
                                               static_cast<double>(kUnity));
        }
        // The held gain falls immediately and rises exponentially; rounding up lets it reach one.
        const double rise = std::ceil(static_cast<double>(kUnity - held) * release);
        held = std::min(sliding_minimum(needed), held + static_cast<std::int64_t>(rise));
        sum += held - averaged[position];
        averaged[position] = held;
        position = position + 1 == window ? 0 : position + 1;
        ++now;
        return static_cast<float>(static_cast<double>(sum) /
                                  (static_cast<double>(window) * static_cast<double>(kUnity)));
    }
};

Limiter::Limiter(double sample_rate_hz, std::size_t channels, int max_block)
    : state_(std::make_unique<State>()) {
    State& s = *state_;
    s.window = static_cast<std::size_t>(std::lround(kLookAhead_s * sample_rate_hz));
    s.ceiling = static_cast<float>(std::pow(10.0, kCeiling_db / 20));
    s.release = 1 - std::exp(-1 / (kRelease_s * sample_rate_hz));
    s.gains.resize(static_cast<std::size_t>(max_block));
    s.peaks.resize(static_cast<std::size_t>(max_block));
    s.recent.assign(channels, std::vector<float>(State::kPast + s.gains.size()));
    s.delayed.assign(channels, std::vector<float>(s.latency()));
    for (std::size_t phase = 0; phase < kPhases; ++phase) {
        float sum = 0;
        for (const float tap : s.interpolator.impulse(static_cast<double>(phase) / kPhases)) {
            sum += std::abs(tap);
        }
        s.interpolator_gain = std::max(s.interpolator_gain, sum);
    }
    s.averaged.assign(s.window, kUnity);
    s.sum = static_cast<std::int64_t>(s.window) * kUnity;
    s.candidates.resize(s.window + 2);
}

Limiter::~Limiter() = default;

int Limiter::latency_samples() const { return static_cast<int>(state_->latency()); }

float Limiter::min_gain() const noexcept { return state_->min_gain; }

void Limiter::process(std::span<float* const> channels, int samples) noexcept {
    State& s = *state_;
    const auto count = static_cast<std::size_t>(samples);
    assert(channels.size() == s.delayed.size() && count <= s.gains.size());

    for (std::size_t c = 0; c < channels.size(); ++c)
        std::copy_n(channels[c], count, s.recent[c].data() + State::kPast);
    s.find_peaks(count);
    s.min_gain = 1;
    for (std::size_t i = 0; i < count; ++i) {
        s.gains[i] = s.next_gain(s.peaks[i]);
        s.min_gain = std::min(s.min_gain, s.gains[i]);
    }
    const std::size_t start = s.delayed_position;
    for (std::size_t c = 0; c < channels.size(); ++c) {
        std::size_t position = start;
        for (std::size_t i = 0; i < count; ++i) {
            channels[c][i] = s.delayed[c][position] * s.gains[i];
            s.delayed[c][position] = s.recent[c][State::kPast + i];
            position = position + 1 == s.latency() ? 0 : position + 1;
        }
        s.delayed_position = position;
        std::copy_n(s.recent[c].begin() + static_cast<std::ptrdiff_t>(count), State::kPast,
                    s.recent[c].begin());
    }
}

}  // namespace aula
