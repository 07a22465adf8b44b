#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string_view>
#include <vector>

#include "aula/engine/energy_response.h"

namespace aula {

/// The impulse response of one source at one listener, in world axes. The reverberant part is
/// sampled: ambisonics (ACN, SN3D: W Y Z X ...), sample 0 is the emission, pressure re that at 1 m
/// in a free field. Direct sound and image sources are discrete.
struct ImpulseResponse {
    double sample_rate_hz = 48000;
    std::vector<std::vector<float>> channels;  ///< [(order + 1)^2][sample]
    std::vector<SpecularPath> paths;
};

class NoiseCarriers;

/// The noise of all impulse responses of a scene, to be shared by their builders.
/// `sample_rate_hz` >= 8000. Immutable.
std::shared_ptr<const NoiseCarriers> make_noise_carriers(double sample_rate_hz, std::uint64_t seed);

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
    ~ImpulseResponseBuilder();
    ImpulseResponseBuilder(ImpulseResponseBuilder&&) noexcept;
    ImpulseResponseBuilder& operator=(ImpulseResponseBuilder&&) noexcept;

    void build(const EnergyResponse& energy, ImpulseResponse& out);

    std::size_t length_samples() const;

    /// Memory of this builder without the shared carriers.
    std::size_t memory_bytes() const;

 private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace aula
