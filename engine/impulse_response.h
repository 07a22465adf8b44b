#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "engine/arrival_field.h"
#include "engine/energy_response.h"

namespace aula {

/// What is heard of one source at one listener, in world axes. The reverberant part is sampled:
/// ambisonics (ACN, SN3D: W Y Z X ...), sample 0 is emission, pressure 1 at 1 m in free field.
/// Direct sound and image sources stay discrete, for delay lines and ears.
struct ImpulseResponse {
    double sample_rate_hz = 48000;
    std::vector<std::vector<float>> channels;  ///< [(order + 1)^2][sample]
    std::vector<SpecularPath> paths;
};

/// Turns energy responses into impulse responses: seeded white noise through a power-complementary
/// octave filter bank, levelled over short times (the carriers), each shaped by the square root of
/// its band's energy and scaled so that the band's total is exact, then mixed to arrive from where
/// the energy comes from. The carriers never change, so from frame to frame only energies and
/// directions are heard; W is the same for every order. Allocates. [propagation thread]
class ImpulseResponseBuilder {
 public:
    /// Responses last `length_s`; of a longer energy response the rest is left out, after a shorter
    /// one there is silence. `sample_rate_hz` >= 8000; `ambisonic_order` 0 to 3.
    ImpulseResponseBuilder(double sample_rate_hz, double length_s, std::uint64_t seed,
                           int ambisonic_order = 1);

    void build(const EnergyResponse& energy, ImpulseResponse& out) const;

    std::size_t length_samples() const { return length_samples_; }

 private:
    /// Power moments of a channel's carriers over one cell of half a millisecond: the sums of
    /// c^2, c^2 t and c^2 t^2, t in samples from the cell's start. They give the energy of a
    /// carrier under a linear envelope without a pass over its samples.
    struct Moments {
        Bands zeroth, first, second;
    };
    struct Channel {
        /// [band][sample], in steps of 1 / 32767 of the band's peak: reading them takes most of the
        /// time, and the error is 88 dB below the band.
        std::array<std::vector<std::int16_t>, kBandCount> carriers;
        Bands step;
        std::vector<Moments> moments;  ///< [cell]
    };
    struct Segment;
    std::vector<Segment> envelope(const EnergyResponse& energy) const;
    Bands wanted_energy(const EnergyResponse& energy) const;
    Bands gains(const Channel& channel, const std::vector<Segment>& segments,
                const Bands& wanted) const;

    double start_samples(std::size_t cell) const;
    std::size_t first_sample(std::size_t cell) const;
    float middle(std::size_t sample, std::size_t cell) const;

    double sample_rate_hz_;
    std::size_t length_samples_;
    Bands band_power_;  ///< what white noise of unit variance has in each band; sums to 1
    ArrivalField field_;
    std::vector<Channel> channels_;  ///< independent
};

}  // namespace aula
