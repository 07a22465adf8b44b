#pragma once

#include <cstddef>
#include <memory>
#include <string_view>
#include <vector>

#include "engine/response/directional_covariance.h"
#include "engine/response/energy_response.h"
#include "engine/response/noise_carriers.h"

namespace aula {

/// What is heard of one source at one listener, in world axes. The reverberant part is sampled:
/// ambisonics (ACN, SN3D: W Y Z X ...), sample 0 is emission, pressure 1 at 1 m in free field.
/// Direct sound and image sources stay discrete, for delay lines and ears.
struct ImpulseResponse {
    double sample_rate_hz = 48000;
    std::vector<std::vector<float>> channels;  ///< [(order + 1)^2][sample]
    std::vector<SpecularPath> paths;
};

/// Turns the energy responses of one source into impulse responses: noise carriers, each shaped by
/// the square root of its band's energy and scaled so that the band's total is exact, then mixed to
/// arrive from where the energy comes from. The carriers never change, so from frame to frame only
/// energies and directions are heard; W is the same for every order. Those of two sources are
/// independent. Allocates. [propagation thread]
class ImpulseResponseBuilder {
 public:
    /// Responses last `length_s`; of a longer energy response the rest is left out, after a shorter
    /// one there is silence. `source` is the source's name, `ambisonic_order` 0 to 3.
    ImpulseResponseBuilder(std::shared_ptr<const NoiseCarriers> carriers, double length_s,
                           std::string_view source, int ambisonic_order = 1);

    void build(const EnergyResponse& energy, ImpulseResponse& out);

    std::size_t length_samples() const { return length_samples_; }

    /// Of this source alone, without the carriers.
    std::size_t memory_bytes() const;

 private:
    /// Power moments of a channel's carriers over one segment of the envelope: the sums of
    /// c^2, c^2 t and c^2 t^2, t in samples from the segment's start. They give the energy of a
    /// carrier under a linear envelope without a pass over its samples.
    struct Moments {
        Bands zeroth, first, second;
    };
    struct Channel {
        std::size_t place = 0;         ///< of its carriers
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
    std::vector<Channel> channels_;  ///< independent
    TimeBins bins_;                  ///< that the moments are of
};

}  // namespace aula
