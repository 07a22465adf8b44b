#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "engine/base/fft.h"
#include "engine/response/third_octave_model.h"

namespace aula {

class CarrierFilters;

/// Noise carriers of impulse responses: a seeded white sequence, split into third octaves and
/// levelled to constant short-time power. The lowest carrier extends down to 0 Hz, the highest up
/// to half of the sample rate. Their powers sum to 1 at each frequency, and those that overlap are
/// a quarter of a period apart, so that powers add: all together are white noise. The sequence is
/// periodic, by default in about kPeriod_s, and shared by all sources of a scene; each channel of
/// each source starts reading at a different offset, and so does each plane wave of the low
/// carriers, those below kHigh, which have one sample of decimation() samples. Immutable.
class NoiseCarriers {
 public:
    /// Longer than most responses: reads at different offsets overlap little. A choice of memory.
    static constexpr double kPeriod_s = 8;
    static constexpr std::size_t kMaxChannels = 16;        ///< third-order ambisonics
    static constexpr std::size_t kMaxRead_samples = 1024;  ///< a block of PlaneWaveTail
    static constexpr std::size_t kCount = ThirdOctaveModel::kCount;
    static constexpr std::size_t kHigh = 16;  ///< the first carrier at the full rate: 2 kHz

    using Values = ThirdOctaveModel::Values;  ///< [carrier]

    /// `sample_rate_hz` >= 8000.
    NoiseCarriers(double sample_rate_hz, std::uint64_t seed);

    /// Carriers from a given period of white noise of unit variance, of the filters' period.
    NoiseCarriers(const CarrierFilters& filters, const std::vector<float>& noise);

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

    /// The start of the high carriers of a channel of a source in the period, samples. It depends
    /// on the seed, the room and the name only, so that a source sounds the same with any other
    /// sources.
    std::size_t offset(std::uint64_t room, std::string_view source, std::size_t channel) const;

    /// The seed of the plane waves of a source, likewise.
    std::uint64_t waves_seed(std::uint64_t room, std::string_view source) const;

    /// The period of the low carriers, in samples of theirs.
    std::size_t low_period_samples() const { return period_samples_ / decimation_; }

    /// The position of a sample of the high carriers after an offset.
    std::size_t position(std::size_t offset, std::size_t sample) const {
        return (offset + sample) % period_samples_;
    }

    /// The kMaxRead_samples samples of a carrier from a position on, in units of step().
    const std::int16_t* read(std::size_t carrier, std::size_t position) const {
        return carriers_[carrier].data() + position;
    }

    std::size_t memory_bytes() const;

 private:
    NoiseCarriers(const CarrierFilters& filters, std::uint64_t seed,
                  const std::vector<float>& noise);

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

/// What the carriers of a sample rate and a period have in common. Immutable.
class CarrierFilters {
 public:
    /// Amplitudes of a carrier in the bins from `first` on.
    struct Weights {
        std::size_t first = 0;
        std::vector<float> weight;
    };

    /// `sample_rate_hz` >= 8000; `period_samples`: at least 0.5 s, a length that
    /// NoiseCarriers::fast_period() returns.
    CarrierFilters(double sample_rate_hz, std::size_t period_samples);

    double sample_rate_hz() const { return sample_rate_hz_; }
    std::size_t period_samples() const { return high_.size(); }
    std::size_t decimation() const { return high_.size() / low_.size(); }

    /// The squares of the weights of all carriers sum to 1.
    std::span<const Weights> weights() const { return weights_; }

    /// The transform of the period of the low carriers, and of the others.
    const Fft& low() const { return low_; }
    const Fft& high() const { return high_; }

 private:
    double sample_rate_hz_;
    Fft low_, high_;
    std::array<Weights, NoiseCarriers::kCount> weights_;
};

}  // namespace aula
