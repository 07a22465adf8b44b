#include "engine/tail/plane_wave_tail.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <numbers>
#include <span>

#include "engine/base/sampling.h"
#include "engine/base/spherical_harmonics.h"
#include "engine/tail/windowed_sinc.h"
#include "process/multiversion.h"

namespace aula {
namespace {

constexpr std::size_t kLow = NoiseCarriers::kHigh;

// Blocks overlap by a period of the lowest octaves, and are short, so that a tail consists of many
// waves: the correlation over a distance that K fixed waves leave is about 1 / sqrt(2 K).
constexpr double kBlock_s = 0.064;
constexpr double kFade_s = 0.024;

/// Taps that shift by a fraction of a sample. The error is below -39 dB up to 2 kHz, where the low
/// carriers end, and with the few taps of the octaves up to 500 Hz up to 1 kHz, where these end.
constexpr std::size_t kShiftTaps = 8;
constexpr std::size_t kFewTaps = 4;
constexpr std::size_t kShiftBefore = kShiftTaps / 2 - 1;
constexpr double kShiftShape = 4.25;  // of Kaiser's window for -39 dB

/// Samples that are computed together.
constexpr std::size_t kGroup = 16;
using Group = float __attribute__((vector_size(kGroup * sizeof(float))));
using Steps = std::int16_t __attribute__((vector_size(kGroup * sizeof(std::int16_t))));

// A block with both of its fades, and what shifts and groups add.
constexpr double kHighestRate_hz = 11000;
static_assert((kBlock_s + kFade_s) * kHighestRate_hz + kShiftTaps + 2 * kGroup <
              NoiseCarriers::kMaxRead_samples);

template <std::size_t kTaps>
using ShiftWeights = std::array<float, kTaps>;

/// Steps of a fraction: half of one is an error of -47 dB at 2 kHz.
constexpr std::size_t kFractions = 256;

/// Weights that shift by a fraction of a sample, of the sum 1.
template <std::size_t kTaps>
ShiftWeights<kTaps> shift_weights(double fraction) {
    constexpr double kBefore = kTaps / 2 - 1;
    std::array<double, kTaps> w{};
    double sum = 0;
    for (std::size_t t = 0; t < kTaps; ++t)
        sum += w[t] =
            windowed_sinc(static_cast<double>(t) - kBefore - fraction, kTaps, kShiftShape);
    ShiftWeights<kTaps> weights{};
    for (std::size_t t = 0; t < kTaps; ++t) weights[t] = static_cast<float>(w[t] / sum);
    return weights;
}

/// The weights of the middle of each step.
template <std::size_t kTaps>
const std::array<ShiftWeights<kTaps>, kFractions>& all_shift_weights() {
    static const auto all = [] {
        std::array<ShiftWeights<kTaps>, kFractions> weights{};
        for (std::size_t i = 0; i < kFractions; ++i)
            weights[i] = shift_weights<kTaps>((static_cast<double>(i) + 0.5) / double{kFractions});
        return weights;
    }();
    return all;
}

[[gnu::always_inline]] inline Group load_group(const float* from) {
    Group lanes;
    std::memcpy(&lanes, from, sizeof lanes);
    return lanes;
}

// The carriers of an octave with their envelopes, up to the next multiple of kGroup.
template <std::size_t kThirds>
AULA_MULTIVERSION void shape_octave(std::size_t count,
                                    const std::array<const std::int16_t*, kThirds>& carrier,
                                    const std::array<const float*, kThirds>& envelope, float* out) {
    for (std::size_t n = 0; n < count; n += kGroup) {
        Group sum{};
        for (std::size_t k = 0; k < kThirds; ++k) {
            Steps steps;
            std::memcpy(&steps, carrier[k] + n, sizeof steps);
            sum += load_group(envelope[k] + n) * __builtin_convertvector(steps, Group);
        }
        std::memcpy(out + n, &sum, sizeof sum);
    }
}

/// Waves that are added together, so that sums are loaded and stored once for all of them.
constexpr std::size_t kTogether = 4;
static_assert(kPlaneWaves / 2 % kTogether == 0);

/// Waves of a block with the envelopes of an octave.
template <std::size_t kTaps>
struct ShapedWaves {
    std::array<const float*, kTogether> samples;
    std::array<const ShiftWeights<kTaps>*, kTogether> weights;
    std::array<const float*, kTogether> gains;  ///< [channel]
};

// Adds waves, shifted by fractions of a sample and faded, to each channel, up to the next multiple
// of kGroup.
template <std::size_t kTaps>
AULA_MULTIVERSION void add_waves(std::size_t count, const ShapedWaves<kTaps>& waves,
                                 const float* window, std::span<std::vector<float>> out) {
    for (std::size_t n = 0; n < count; n += kGroup) {
        const Group fade = load_group(window + n);
        std::array<Group, kTogether> wave;
        for (std::size_t i = 0; i < kTogether; ++i) {
            const ShiftWeights<kTaps>& weights = *waves.weights[i];
            Group sum{};
            for (std::size_t t = 0; t < kTaps; ++t)
                sum += weights[t] * load_group(waves.samples[i] + n + t);
            wave[i] = fade * sum;
        }
        for (std::size_t c = 0; c < out.size(); ++c) {
            float* const to = out[c].data() + n;
            Group sum = load_group(to);
            for (std::size_t i = 0; i < kTogether; ++i) sum += waves.gains[i][c] * wave[i];
            std::memcpy(to, &sum, sizeof sum);
        }
    }
}

}  // namespace

PlaneWaveTail::PlaneWaveTail(std::shared_ptr<const NoiseCarriers> carriers, std::size_t channels,
                             std::size_t samples, std::uint64_t seed)
    : carriers_(std::move(carriers)),
      channels_(channels),
      sums_(kOctaves * channels, std::vector<float>(samples)),
      envelopes_(kLow, std::vector<float>(NoiseCarriers::kMaxRead_samples)),
      block_sums_(channels, std::vector<float>(NoiseCarriers::kMaxRead_samples)),
      window_(NoiseCarriers::kMaxRead_samples),
      shaped_(kTogether * NoiseCarriers::kMaxRead_samples) {
    const double rate_hz =
        carriers_->sample_rate_hz() / static_cast<double>(carriers_->decimation());
    block_samples_ = static_cast<std::size_t>(kBlock_s * rate_hz);
    // Vorbis's window.
    fade_.resize(static_cast<std::size_t>(kFade_s * rate_hz));
    for (std::size_t n = 0; n < fade_.size(); ++n) {
        const double s = std::sin(std::numbers::pi / 2 * (static_cast<double>(n) + 0.5) /
                                  static_cast<double>(fade_.size()));
        fade_[n] = static_cast<float>(std::sin(std::numbers::pi / 2 * s * s));
    }
    int order = 0;
    while (static_cast<std::size_t>((order + 1) * (order + 1)) < channels) ++order;
    waves_.resize((samples + block_samples_ - 1) / block_samples_);
    for (std::size_t b = 0; b < waves_.size(); ++b) {
        const std::uint64_t of_block = derive_seed(seed, b);
        const auto directions = wave_directions(derive_seed(of_block, 0));
        waves_[b].resize(plane_waves(order));
        for (std::size_t i = 0; i < waves_[b].size(); ++i) {
            Wave& wave = waves_[b][i];
            wave.position = derive_seed(of_block, 1, i) % carriers_->low_period_samples();
            wave.direction = directions[i];
            std::array<double, NoiseCarriers::kMaxChannels> harmonics{};
            spherical_harmonics(wave.direction, order, harmonics.data());
            for (std::size_t c = 0; c < channels; ++c) {
                const double degree = std::floor(std::sqrt(static_cast<double>(c) + 0.5));
                wave.gains[c] = static_cast<float>(
                    harmonics[c] *
                    std::sqrt((2 * degree + 1) / static_cast<double>(waves_[b].size())));
            }
        }
    }
}

/// Samples the envelopes from `begin` to `end`, with those samples before and after them that a
/// shift needs: element 0 is the sample `begin` - kShiftBefore. The unit is a step of the carrier.
void PlaneWaveTail::sample_envelopes(const std::vector<TailSegment>& segments,
                                     const NoiseCarriers::Values& amplitudes, std::size_t begin,
                                     std::size_t end) {
    const double step_s =
        static_cast<double>(carriers_->decimation()) / carriers_->sample_rate_hz();
    // The first sample from a time on; a time that is whole but for rounding is that sample.
    const auto sample_at = [&](double time_s) { return std::ceil(time_s / step_s - 1e-6); };
    const double first = static_cast<double>(begin) - double{kShiftBefore};
    const auto count = static_cast<double>(end - begin + kShiftTaps - 1);
    for (std::vector<float>& envelope : envelopes_)
        std::fill(envelope.begin(), envelope.end(), 0.0F);
    audible_ = {};
    const double end_s = (first + count) * step_s;
    auto s = std::partition_point(segments.begin(), segments.end(), [&](const TailSegment& x) {
        return sample_at(x.end_s) <= first;
    });
    for (; s != segments.end() && s->begin_s < end_s; ++s) {
        const double from = std::max(sample_at(s->begin_s) - first, 0.0);
        const double to = std::min(sample_at(s->end_s) - first, count);
        if (from >= to) continue;
        const auto samples = static_cast<std::size_t>(to - from);
        for (std::size_t k = 0; k < kLow; ++k) {
            if (amplitudes[k] == 0 || !s->is_audible(k)) continue;
            audible_[k / 3] = true;
            const double slope = double{s->end[k] - s->begin[k]} / (s->end_s - s->begin_s);
            const double at_s = (first + from) * step_s - s->begin_s;
            const float unit = carriers_->step()[k] * amplitudes[k];
            const auto level = unit * static_cast<float>(double{s->begin[k]} + slope * at_s);
            const auto rise = unit * static_cast<float>(slope * step_s);
            float* const out = envelopes_[k].data() + static_cast<std::size_t>(from);
            for (std::size_t n = 0; n < samples; ++n)
                out[n] = level + rise * static_cast<float>(static_cast<int>(n));
        }
    }
}

/// Sets the window of a block of `count` samples: its squares and those of the blocks before and
/// after it sum to 1.
void PlaneWaveTail::set_window(std::size_t count, bool has_before) {
    std::fill(window_.begin(), window_.end(), 0.0F);
    std::fill_n(window_.begin(), count, 1.0F);
    const std::size_t whole = block_samples_ + fade_.size();
    for (std::size_t n = 0; n < fade_.size(); ++n) {
        if (has_before && n < count) window_[n] = fade_[n];
        if (whole - 1 - n < count) window_[whole - 1 - n] *= fade_[n];
    }
}

/// Where a wave's carriers are read for a block that begins at `begin`.
PlaneWaveTail::Reading PlaneWaveTail::reading(const Wave& wave, const Vec3& place,
                                              std::size_t begin) const {
    const double shift_samples = glm::dot(glm::dvec3(wave.direction), glm::dvec3(place));
    const double whole = std::floor(shift_samples);
    const auto period = static_cast<std::ptrdiff_t>(carriers_->low_period_samples());
    const auto from = static_cast<std::ptrdiff_t>(wave.position + begin) +
                      static_cast<std::ptrdiff_t>(whole) -
                      static_cast<std::ptrdiff_t>(kShiftBefore);
    return {static_cast<std::size_t>((from % period + period) % period),
            static_cast<std::size_t>((shift_samples - whole) * double{kFractions})};
}

/// Adds the waves of a block of `count` samples to the sums of an octave, which has `kThirds` low
/// carriers.
template <std::size_t kThirds, std::size_t kTaps>
void PlaneWaveTail::add_octave(std::size_t octave, std::size_t block, const Vec3& place,
                               std::size_t count) {
    const std::size_t begin = block * block_samples_;
    for (std::vector<float>& sum : block_sums_) std::fill(sum.begin(), sum.end(), 0.0F);
    std::array<const float*, kThirds> envelope{};
    for (std::size_t k = 0; k < kThirds; ++k) envelope[k] = envelopes_[3 * octave + k].data();
    for (std::size_t first = 0; first < waves_[block].size(); first += kTogether) {
        ShapedWaves<kTaps> waves{};
        for (std::size_t i = 0; i < kTogether; ++i) {
            const Wave& wave = waves_[block][first + i];
            const Reading at = reading(wave, place, begin);
            std::array<const std::int16_t*, kThirds> carrier{};
            for (std::size_t k = 0; k < kThirds; ++k)
                carrier[k] = carriers_->read(3 * octave + k, at.position);
            float* const shaped = shaped_.data() + i * NoiseCarriers::kMaxRead_samples;
            best_version<shape_octave<kThirds>>(count + kShiftTaps - 1, carrier, envelope, shaped);
            waves.samples[i] = shaped + (kShiftTaps - kTaps) / 2;
            waves.weights[i] = &all_shift_weights<kTaps>()[std::min(at.step, kFractions - 1)];
            waves.gains[i] = wave.gains.data();
        }
        best_version<add_waves<kTaps>>(count, waves, window_.data(),
                                       std::span<std::vector<float>>(block_sums_));
    }
    for (std::size_t c = 0; c < channels_; ++c) {
        float* const to = sums_[octave * channels_ + c].data() + begin;
        for (std::size_t n = 0; n < count; ++n) to[n] += block_sums_[c][n];
    }
}

void PlaneWaveTail::build(const std::vector<TailSegment>& segments,
                          const NoiseCarriers::Values& amplitudes, const Vec3& place,
                          std::size_t samples) {
    assert(samples <= sums_[0].size());
    for (std::vector<float>& sum : sums_) std::fill(sum.begin(), sum.end(), 0.0F);
    for (std::size_t b = 0; b < waves_.size(); ++b) {
        const std::size_t begin = b * block_samples_;
        if (begin >= samples) break;
        const std::size_t count = std::min(block_samples_ + fade_.size(), samples - begin);
        sample_envelopes(segments, amplitudes, begin, begin + count);
        set_window(count, b > 0);
        for (std::size_t o = 0; o + 2 < kOctaves; ++o)
            if (audible_[o]) add_octave<3, kFewTaps>(o, b, place, count);
        if (audible_[kOctaves - 2]) add_octave<3, kShiftTaps>(kOctaves - 2, b, place, count);
        if (audible_[kOctaves - 1])
            add_octave<kLow - 3 * (kOctaves - 1), kShiftTaps>(kOctaves - 1, b, place, count);
    }
}

std::size_t PlaneWaveTail::memory_bytes() const {
    std::size_t bytes =
        sizeof *this + waves_.capacity() * sizeof(std::vector<Wave>) +
        waves_.size() * waves_[0].capacity() * sizeof(Wave) +
        (fade_.capacity() + window_.capacity() + shaped_.capacity()) * sizeof(float);
    for (const auto* const all : {&sums_, &envelopes_, &block_sums_})
        for (const std::vector<float>& each : *all) bytes += each.capacity() * sizeof(float);
    return bytes;
}

}  // namespace aula
