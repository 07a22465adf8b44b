#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "aula/engine/bands.h"

namespace aula {

/// Noise carriers of impulse responses: a seeded white sequence, split by a power-complementary
/// octave filter bank and levelled to constant short-time power. The sequence is periodic, by
/// default in kPeriod_s, and shared by all sources of a scene; each channel of each source starts
/// reading at a different offset. All bands of a channel have the same offset: they are parts of
/// one white noise, so that overlapping bands do not interfere. Immutable.
class NoiseCarriers {
 public:
    static constexpr double kPeriod_s = 8;
    static constexpr std::size_t kMaxChannels = 16;  ///< third-order ambisonics
    static constexpr std::size_t kMaxRead_samples = 1024;

    /// `sample_rate_hz` >= 8000.
    NoiseCarriers(double sample_rate_hz, std::uint64_t seed);

    /// Carriers from a given period of white noise of unit variance, at least 0.5 s long.
    NoiseCarriers(double sample_rate_hz, const std::vector<double>& noise);

    /// A seed that depends on another one and on the name of a source.
    static std::uint64_t source_seed(std::uint64_t seed, std::string_view source);

    double sample_rate_hz() const { return sample_rate_hz_; }

    /// The power of the carriers in each band: that of white noise of unit variance; sums to 1.
    const Bands& power() const { return power_; }

    /// The quantisation step of read().
    const Bands& step() const { return step_; }

    /// The start of a channel of a source in the period, samples. It depends on the seed and the
    /// name only, so that a source sounds the same with any other sources.
    std::size_t offset(std::string_view source, std::size_t channel) const;

    /// The kMaxRead_samples samples of a band from `sample` after an offset, in units of step().
    const std::int16_t* read(std::size_t band, std::size_t offset, std::size_t sample) const {
        return carriers_[band].data() + (offset + sample) % period_samples_;
    }

    std::size_t memory_bytes() const;

 private:
    NoiseCarriers(double sample_rate_hz, std::uint64_t seed, const std::vector<double>& noise);

    double sample_rate_hz_;
    std::uint64_t seed_;
    std::size_t period_samples_;
    Bands power_;
    Bands step_;
    /// [band][sample], followed by the first kMaxRead_samples again. Quantised to 1 / 32767 of the
    /// band's peak, since memory bandwidth limits the speed; the error is -88 dB.
    std::array<std::vector<std::int16_t>, kBandCount> carriers_;
};

}  // namespace aula
