#pragma once

#include <cstddef>
#include <memory>
#include <string_view>
#include <vector>

#include "engine/response/directional_covariance.h"
#include "engine/response/energy_response.h"
#include "engine/response/noise_carriers.h"

namespace aula {

/// The impulse response of one source at one listener, in world axes. The reverberant part is
/// sampled: ambisonics (ACN, SN3D: W Y Z X ...), sample 0 is the emission, pressure re that at 1 m
/// in a free field. Direct sound and image sources are discrete.
struct ImpulseResponse {
    double sample_rate_hz = 48000;
    std::vector<std::vector<float>> channels;  ///< [(order + 1)^2][sample]
    std::vector<SpecularPath> paths;
};

/// Synthesises impulse responses from the energy responses of one source. Noise carriers are shaped
/// by the square root of the energy of each band, scaled such that the total of each band is exact,
/// and mixed to the directional covariance of the field. The carriers are constant: from frame to
/// frame only energies and directions change. W is the same for every order. Carriers of different
/// sources are independent. Allocates. [propagation thread]
class ImpulseResponseBuilder {
 public:
    /// Responses have the length `length_s`: longer energy responses are truncated, shorter ones
    /// are padded with silence. `source` is the source's name, `ambisonic_order` 0 to 3.
    ImpulseResponseBuilder(std::shared_ptr<const NoiseCarriers> carriers, double length_s,
                           std::string_view source, int ambisonic_order = 1);

    void build(const EnergyResponse& energy, ImpulseResponse& out);

    std::size_t length_samples() const { return length_samples_; }

    /// Memory of this builder without the shared carriers.
    std::size_t memory_bytes() const;

 private:
    /// Moments of the power of a channel's carriers over a segment of the envelope: the sums of
    /// c^2, c^2 t and c^2 t^2, t in samples from the segment's start. The energy of a carrier with
    /// a linear envelope follows from them without a pass over its samples.
    struct Moments {
        Bands zeroth, first, second;
    };
    struct Channel {
        std::size_t place = 0;         ///< start of its carriers
        std::vector<Moments> moments;  ///< [segment]
    };
    struct Segment;
    std::vector<Segment> envelope(const EnergyResponse& energy) const;
    Bands wanted_energy(const EnergyResponse& energy) const;
    void measure_carriers(const TimeBins& bins, const std::vector<Segment>& segments);
    Moments moments(const Channel& channel, const Segment& segment) const;
    Bands gains(const Channel& channel, const std::vector<Segment>& segments,
                const Bands& wanted) const;

    double start_samples(std::size_t cell) const;
    std::size_t first_sample(std::size_t cell) const;
    float middle(std::size_t sample, std::size_t cell) const;

    std::shared_ptr<const NoiseCarriers> carriers_;
    std::size_t length_samples_;
    DirectionalCovariance field_;
    std::vector<Channel> channels_;  ///< before mixing
    TimeBins bins_;                  ///< time axis of the moments
};

}  // namespace aula
