#include "audio/limiter.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <vector>

namespace aula {

namespace {

constexpr double kCeiling_db = -1;
constexpr double kLookAhead_s = 0.004;
constexpr double kRelease_s = 0.1;

// Gains are whole numbers of 2^-30, so that a running sum of them stays exact and a gain of one
// passes the sound through bit by bit.
constexpr std::int64_t kUnity = std::int64_t{1} << 30;

}  // namespace

// The gain that a peak needs is held over the whole look-ahead (sliding minimum), released
// exponentially, and averaged over the look-ahead: when the delayed peak leaves, every term of the
// average is at most the gain it needs.
struct Limiter::State {
    std::size_t window = 0;
    float ceiling = 0;
    double release = 0;

    std::vector<float> gains;                 ///< of the block in hand
    std::vector<std::vector<float>> delayed;  ///< [channel][window]
    std::vector<std::int64_t> averaged;
    std::int64_t sum = 0;  ///< of `averaged`
    std::int64_t held = kUnity;
    std::size_t position = 0;
    std::uint64_t now = 0;
    float least_gain = 1;

    /// Candidates of the sliding minimum, times and gains ascending; a ring.
    struct Candidate {
        std::uint64_t time;
        std::int64_t gain;
    };
    std::vector<Candidate> candidates;
    std::size_t first = 0;
    std::size_t count = 0;

    Candidate& candidate(std::size_t i) { return candidates[(first + i) % candidates.size()]; }

    /// The smallest gain of this sample and the `window` before it: all averages that the delayed
    /// peak passes through know it.
    std::int64_t sliding_minimum(std::int64_t gain) {
        while (count > 0 && candidate(count - 1).gain >= gain) --count;
        candidate(count++) = {now, gain};
        if (candidate(0).time + window < now) {
            first = (first + 1) % candidates.size();
            --count;
        }
        return candidate(0).gain;
    }

    /// Takes in the peak of the newest sample, gives the gain of the sample `window` before it.
    float next_gain(float peak) {
        std::int64_t needed = kUnity;
        if (peak > ceiling) {
            // A shade less, for the rounding of the gain to a float.
            needed = static_cast<std::int64_t>(double{ceiling} / double{peak} * (1 - 2e-7) *
                                               static_cast<double>(kUnity));
        }
        // Down at once, up exponentially; rounding up makes it arrive.
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
    s.delayed.assign(channels, std::vector<float>(s.window));
    s.averaged.assign(s.window, kUnity);
    s.sum = static_cast<std::int64_t>(s.window) * kUnity;
    s.candidates.resize(s.window + 2);
}

Limiter::~Limiter() = default;

int Limiter::latency_samples() const { return static_cast<int>(state_->window); }

float Limiter::least_gain() const noexcept { return state_->least_gain; }

void Limiter::process(std::span<float* const> channels, int samples) noexcept {
    State& s = *state_;
    const auto count = static_cast<std::size_t>(samples);
    assert(channels.size() == s.delayed.size() && count <= s.gains.size());

    const std::size_t start = s.position;
    s.least_gain = 1;
    for (std::size_t i = 0; i < count; ++i) {
        float peak = 0;
        for (float* const channel : channels) peak = std::max(peak, std::abs(channel[i]));
        s.gains[i] = s.next_gain(peak);
        s.least_gain = std::min(s.least_gain, s.gains[i]);
    }
    for (std::size_t c = 0; c < channels.size(); ++c) {
        std::size_t position = start;
        for (std::size_t i = 0; i < count; ++i) {
            const float in = channels[c][i];
            channels[c][i] = s.delayed[c][position] * s.gains[i];
            s.delayed[c][position] = in;
            position = position + 1 == s.window ? 0 : position + 1;
        }
    }
}

}  // namespace aula
