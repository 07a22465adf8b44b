#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "engine/response/third_octave_model.h"

namespace aula {

/// Noise carriers of impulse responses: a seeded white sequence, split into third octaves and
/// levelled to constant short-time power. The lowest carrier extends down to 0 Hz, the highest up
/// to half of the sample rate. Their powers sum to 1 at each frequency, and those that overlap are
/// a quarter of a period apart, so that powers add: all together are white noise. The sequence is
/// periodic, by default in about kPeriod_s, and shared by all sources of a scene; each channel of
/// each source starts reading at a different offset. Carriers below kHigh have one sample of
/// decimation() samples. Immutable.
class NoiseCarriers {
 public:
    static constexpr double kPeriod_s = 8;
    static constexpr std::size_t kMaxChannels = 16;  ///< third-order ambisonics
    static constexpr std::size_t kMaxRead_samples = 1024;
    static constexpr std::size_t kCount = ThirdOctaveModel::kCount;
    static constexpr std::size_t kHigh = 15;  ///< the first carrier at the full rate: 1.6 kHz

    using Values = ThirdOctaveModel::Values;  ///< [carrier]

    /// `sample_rate_hz` >= 8000.
    NoiseCarriers(double sample_rate_hz, std::uint64_t seed);

    /// Carriers from a given period of white noise of unit variance, at least 0.5 s long, of a
    /// length that fast_period() returns.
    NoiseCarriers(double sample_rate_hz, const std::vector<float>& noise);

    /// The shortest possible period, samples, of at least `least`.
    static std::size_t fast_period(double sample_rate_hz, std::size_t least);

    /// A seed that depends on another one and on the name of a source.
    static std::uint64_t source_seed(std::uint64_t seed, std::string_view source);

    double sample_rate_hz() const { return sample_rate_hz_; }

    /// Samples per sample of the low carriers, a power of two.
    std::size_t decimation() const { return decimation_; }

    /// The power of the carriers: that of white noise of unit variance; sums to 1.
    const Values& power() const { return power_; }

    /// The quantisation step of read().
    const Values& step() const { return step_; }

    /// The start of a channel of a source in the period, samples, a multiple of decimation(). It
    /// depends on the seed and the name only, so that a source sounds the same with any other
    /// sources.
    std::size_t offset(std::string_view source, std::size_t channel) const;

    /// The position of a sample of the high carriers after an offset. `is_low`: of the low ones,
    /// with `sample` in samples of theirs.
    std::size_t position(bool is_low, std::size_t offset, std::size_t sample) const {
        return is_low ? (offset / decimation_ + sample) % (period_samples_ / decimation_)
                      : (offset + sample) % period_samples_;
    }

    /// The kMaxRead_samples samples of a carrier from a position on, in units of step().
    const std::int16_t* read(std::size_t carrier, std::size_t position) const {
        return carriers_[carrier].data() + position;
    }

    std::size_t memory_bytes() const;

 private:
    NoiseCarriers(double sample_rate_hz, std::uint64_t seed, const std::vector<float>& noise);

    double sample_rate_hz_;
    std::uint64_t seed_;
    std::size_t period_samples_;
    std::size_t decimation_;
    Values power_{};
    Values step_{};
    /// [carrier][sample], followed by the first kMaxRead_samples again. Quantised to 1 / 32767 of
    /// the carrier's peak, since memory bandwidth limits the speed; the error is -88 dB.
    std::array<std::vector<std::int16_t>, kCount> carriers_;
};

}  // namespace aula
