#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "engine/base/bands.h"

namespace aula {

/// The noise that energy responses shape: a seeded white sequence through a power-complementary
/// octave filter bank, its power levelled over short times. All sources of a scene share its
/// memory: it repeats after kPeriod_s, and each channel of each source begins to read at its own
/// place. All bands of a channel begin at the same place, where they are parts of the same white
/// noise, so that neighbours do not interfere where they overlap. Immutable.
class NoiseCarriers {
 public:
    static constexpr double kPeriod_s = 8;
    static constexpr std::size_t kMostChannels = 16;  ///< of ambisonics of order 3
    static constexpr std::size_t kMostRead_samples = 1024;

    /// `sample_rate_hz` >= 8000.
    NoiseCarriers(double sample_rate_hz, std::uint64_t seed);

    double sample_rate_hz() const { return sample_rate_hz_; }

    /// What white noise of unit variance has in each band; sums to 1. So have the carriers.
    const Bands& power() const { return power_; }

    /// What one unit of read() stands for.
    const Bands& step() const { return step_; }

    /// Where a channel of a source begins in the period: a function of the seed and the name, so
    /// that a source sounds alike whichever others there are. In samples.
    std::size_t place(std::string_view source, std::size_t channel) const;

    /// The next kMostRead_samples of a band, `sample` after a place.
    const std::int16_t* read(std::size_t band, std::size_t place, std::size_t sample) const {
        return carriers_[band].data() + (place + sample) % period_samples_;
    }

    std::size_t memory_bytes() const;

 private:
    double sample_rate_hz_;
    std::uint64_t seed_;
    std::size_t period_samples_;
    Bands power_;
    Bands step_;
    /// [band][sample], and the first kMostRead_samples again. In steps of 1 / 32767 of the band's
    /// peak: reading takes most of the time, and the error is 88 dB below the band.
    std::array<std::vector<std::int16_t>, kBandCount> carriers_;
};

}  // namespace aula
