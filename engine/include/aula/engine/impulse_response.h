#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string_view>
#include <vector>

#include "aula/engine/energy_response.h"
#include "aula/engine/medium.h"

namespace aula {

/// The impulse response of one source at one listener, in world axes. Its reverberant part is
/// sampled. Direct sound and image sources are discrete paths, which `channels` do not contain.
struct ImpulseResponse {
    double sample_rate_hz = 48000;  ///< of `channels`
    /// [channel][sample] Ambisonics of (order + 1)^2 channels (ACN, SN3D: W Y Z X ...). Sample 0 is
    /// the emission. The unit is the pressure at a distance of 1 m in a free field.
    std::vector<std::vector<float>> channels;
    std::vector<SoundPath> paths;  ///< by ascending length
};

/// The factors of the low octaves of a whole response. The beginning of a response at a place
/// nearby has the same. Empty before a whole response.
struct TailScale {
    std::vector<float> gains;  ///< [channel][octave]
};

class NoiseCarriers;

/// Generates the third-octave noise that all impulse responses of a scene are shaped from. Their
/// builders share it. `sample_rate_hz` is at least 8000. Equal seeds give equal noise. The result
/// is immutable and may be used by several threads.
std::shared_ptr<const NoiseCarriers> make_noise_carriers(double sample_rate_hz, std::uint64_t seed);

/// Synthesises impulse responses from the energy responses of one source. Noise carriers are shaped
/// by the square root of the energy of each third octave, with p^2 = 4 pi I: the loss by surfaces
/// is interpolated between octaves, that by air is exact. They are scaled such that the total
/// energy of each octave is exact (in that of 2 kHz, below and above 1.8 kHz), and mixed to the
/// directional covariance of the field (optimal covariance mixing, Vilkamo 2013). Below 1.6 kHz the
/// carriers are a diffuse field in space, at EnergyResponse::listener; above and at one place they
/// are constant: from frame to frame only energies and directions change. Carriers of different
/// rooms (EnergyResponse::room) and of sources with different names are independent. W does not
/// depend on the order. [one thread at a time; allocates]
class ImpulseResponseBuilder {
 public:
    /// Responses have the length `length_s` > 0: longer energy responses are truncated, shorter
    /// ones are padded with silence. `medium` is that of the energy responses. `source` is the
    /// source's name, which selects its carriers. `ambisonic_order` is 0 to 3.
    ImpulseResponseBuilder(std::shared_ptr<const NoiseCarriers> carriers, const Medium& medium,
                           double length_s, std::string_view source, int ambisonic_order = 1);
    ~ImpulseResponseBuilder();
    /// The builder that was moved from can only be assigned to or destroyed.
    ImpulseResponseBuilder(ImpulseResponseBuilder&&) noexcept;
    /// The builder that was moved from can only be assigned to or destroyed.
    ImpulseResponseBuilder& operator=(ImpulseResponseBuilder&&) noexcept;

    /// Synthesises a response. Overwrites `out` and reuses its memory. The reverberation below
    /// `crossover_hz` > 0 is left out: its power rises over an octave about this frequency.
    /// A whole response sets `scale`. Less than length_samples() `samples` are the beginning of a
    /// response, with that scale; if it has none of an octave that sounds, the response is whole.
    void build(const EnergyResponse& energy, ImpulseResponse& out, double crossover_hz = 0,
               TailScale* scale = nullptr, std::size_t samples = kWhole);

    /// All samples of a response.
    static constexpr std::size_t kWhole = static_cast<std::size_t>(-1);

    /// Length of the responses, samples: `length_s` rounded up.
    std::size_t length_samples() const;

    /// Memory of this builder, without the shared noise.
    std::size_t memory_bytes() const;

 private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace aula
