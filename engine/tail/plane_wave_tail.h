#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "engine/response/third_octave_model.h"
#include "engine/tail/noise_carriers.h"
#include "engine/tail/tail_envelope.h"
#include "engine/tail/wave_directions.h"

namespace aula {

/// The low carriers of a tail, as the sum of plane waves at the listener's place. Each wave has
/// carriers of its own, which are shifted by the time that it takes to that place. After each block
/// the waves are replaced by others from other directions. The sums are ambisonic channels (ACN,
/// N3D), at the sample rate of the low carriers. [one thread at a time; allocates]
class PlaneWaveTail {
 public:
    static constexpr std::size_t kOctaves = (NoiseCarriers::kHigh + 2) / 3;

    /// `seed` selects the waves. `samples` of the low carriers are computed.
    PlaneWaveTail(std::shared_ptr<const NoiseCarriers> carriers, std::size_t channels,
                  std::size_t samples, std::uint64_t seed);

    /// Replaces the first `samples` of the sums by those of carriers with the envelopes of
    /// `segments` and the given amplitudes, [carrier]. `place` is that of the listener in units of
    /// the distance that sound travels in a sample of the low carriers.
    void build(const std::vector<TailSegment>& segments, const NoiseCarriers::Values& amplitudes,
               const Vec3& place, std::size_t samples);

    /// The low carriers of an octave of a channel.
    const std::vector<float>& sum(std::size_t octave, std::size_t channel) const {
        return sums_[octave * channels_ + channel];
    }

    std::size_t memory_bytes() const;

 private:
    struct Wave {
        std::size_t position;  ///< of its carriers at the first sample of the response
        Vec3 direction;
        std::array<float, NoiseCarriers::kMaxChannels> gains;  ///< [channel]
    };

    struct Reading {
        std::size_t position;  ///< of the carriers, less what the shift needs
        std::size_t step;      ///< of the fraction of the shift
    };

    void sample_envelopes(const std::vector<TailSegment>& segments,
                          const NoiseCarriers::Values& amplitudes, std::size_t begin,
                          std::size_t end);
    void set_window(std::size_t count, bool has_before);
    Reading reading(const Wave& wave, const Vec3& place, std::size_t begin) const;
    template <std::size_t kThirds, std::size_t kTaps>
    void add_octave(std::size_t octave, std::size_t block, const Vec3& place, std::size_t count);

    std::shared_ptr<const NoiseCarriers> carriers_;
    std::size_t channels_;
    std::size_t block_samples_;
    std::vector<std::vector<Wave>> waves_;  ///< [block][wave]
    std::vector<std::vector<float>> sums_;  ///< [octave][channel]
    std::vector<float> fade_;               ///< the rise of a block's window
    // Work space of a block.
    std::vector<std::vector<float>> envelopes_;   ///< [carrier]
    std::array<bool, kOctaves> audible_{};        ///< one of an octave's carriers
    std::vector<std::vector<float>> block_sums_;  ///< [channel] of an octave
    std::vector<float> window_;
    std::vector<float> shaped_;  ///< [wave] carriers of an octave
};

}  // namespace aula
