#pragma once

#include <complex>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>

#include "apps/room/waves/wave_join.h"
#include "aula/engine/impulse_response.h"

namespace aula {

/// Butterworth's high-pass filter of fourth order: without it the constant pressure of a closed
/// room is 30 dB above the modes at 5 Hz. It is causal because what a linear-phase filter spread
/// before the emission would be lost. `s`: the complex frequency over 2 pi, in Hz.
std::complex<double> wave_high_pass(std::complex<double> s);

/// Builds impulse responses of one length from the energies of rays and, below the crossover, the
/// field of the modes. [one thread at a time]
class WaveSynthesis {
 public:
    WaveSynthesis(double sample_rate_hz, std::size_t length_samples);
    ~WaveSynthesis();

    /// Builds the response of a pair; without `modes` that of rays alone. The field of the modes
    /// contains the paths of the response, except those through walls. As they are played whole,
    /// they are taken out of it, with the delay in s at which each is played. `scale`,
    /// `samples`: as of ImpulseResponseBuilder::build().
    void build(ImpulseResponseBuilder& builder, const EnergyResponse& rays,
               const std::optional<PairWaves>& modes,
               const std::function<double(const SoundPath&)>& delay_s, ImpulseResponse& out,
               TailScale* scale = nullptr, std::size_t samples = ImpulseResponseBuilder::kWhole);

    /// Replaces all of a response below the crossover, channels and paths, by the field of the
    /// modes.
    void replace_below(const PairWaves& modes,
                       const std::function<double(const SoundPath&)>& delay_s,
                       ImpulseResponse& response);

 private:
    class Field;

    Field& field_below(const PairWaves& modes, ImpulseResponse& out);

    double sample_rate_hz_;
    std::size_t length_samples_;
    std::unique_ptr<Field> field_;  ///< for the masks of the last modes
};

}  // namespace aula
