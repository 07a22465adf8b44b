#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <span>
#include <vector>

#include "aula/audio/realtime.h"

namespace aula {

/// Filters from ambisonic channels to the ears: [ear][channel][sample].
using AmbisonicDecoder = std::array<std::vector<std::vector<float>>, 2>;

struct HeadMeasurements;
struct HeadResponses;

/// Head-related impulse responses of a SOFA file at one sample rate, separated into minimum phase
/// and delay, without the common delay, with a diffuse-field level of 0 dB. Immutable; may be
/// shared between threads.
class Hrtf {
 public:
    /// Reads a SOFA file; an empty path means default_head() (MIT KEMAR). Throws InputError, or
    /// Failure if the process that reads the file cannot be started.
    Hrtf(const std::filesystem::path& sofa_file, double sample_rate_hz);

    /// Uses the given measurements. Throws InputError for implausible values.
    Hrtf(const HeadMeasurements& measured, double sample_rate_hz);
    ~Hrtf();

    struct Ear {
        std::vector<float> minimum_phase;  ///< taps() samples
        double delay_s = 0;                ///< >= 0, re the earliest ear of all directions
    };

    /// Both ears (left, right) for a direction in head axes (HeardDirection), interpolated between
    /// the nearest ones of responses(). Without distinctness both ears are equal. Allocates.
    /// [propagation thread]
    std::array<Ear, 2> ears(const std::array<float, 3>& direction) const;

    /// The same, written to filters of taps() samples and delays in s. [audio thread, wait-free]
    void ears(const std::array<float, 3>& direction,
              const std::array<std::span<float>, 2>& minimum_phase,
              std::array<double, 2>& delays_s) const noexcept AULA_NONBLOCKING;

    /// Mean distance of the measured positions, m.
    float distance_m() const noexcept AULA_NONBLOCKING;

    /// Length of the minimum-phase responses, samples.
    std::size_t taps() const;

    /// The responses at the measured directions, and at those that close gaps of the measurement.
    const HeadResponses& responses() const;

    /// The decoder to both ears of an ambisonic field of order 1 to 3, see design_decoder().
    /// Designed at the first call for an order. [any thread but the audio thread]
    const AmbisonicDecoder& decoder(int order) const;

 private:
    struct State;
    std::unique_ptr<State> state_;
};

/// The HRTF of a SOFA file at a sample rate, read unless it is in use in this process and the file
/// has not changed since. Throws as the constructor of Hrtf. [any thread but the audio thread]
std::shared_ptr<const Hrtf> load_hrtf(const std::filesystem::path& sofa_file,
                                      double sample_rate_hz);

}  // namespace aula
