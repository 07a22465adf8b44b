#pragma once

#include <cstdint>
#include <vector>

#include "engine/energy_response.h"

namespace aula {

/// What is heard of one source at one listener, in world axes. The reverberant part is sampled:
/// first-order ambisonics (ACN, SN3D: W Y Z X), sample 0 is emission, pressure 1 at 1 m in free
/// field. Direct sound and image sources stay discrete, for delay lines and ears.
struct ImpulseResponse {
    double sample_rate_hz = 48000;
    std::vector<std::vector<float>> channels;  ///< [4][sample]
    std::vector<SpecularPath> paths;
};

/// Turns energy responses into impulse responses: seeded white noise through a power-complementary
/// octave filter bank (the carriers), each shaped by the square root of its band's energy and
/// scaled so that the band's total is exact. The carriers never change, so from frame to frame only
/// the energies are heard. Allocates in the constructor and where an output has to grow.
/// [propagation thread]
class ImpulseResponseBuilder {
   public:
    ImpulseResponseBuilder(double sample_rate_hz, double length_s, std::uint64_t seed);

    void build(const EnergyResponse& energy, ImpulseResponse& out) const;

    std::size_t length_samples() const { return length_samples_; }

   private:
    double sample_rate_hz_;
    std::size_t length_samples_;
    /// [channel][band][sample]; the channels are independent, the bands of one sum to white noise
    std::vector<std::array<std::vector<float>, kBandCount>> carriers_;
};

}  // namespace aula
