#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <span>
#include <vector>

#include "audio/base/realtime.h"

namespace aula {

struct HeadMeasurements;
struct HeadResponses;

/// Head-related impulse responses of one SOFA file at one sample rate: minimum phase and delay
/// apart, common delay removed, 0 dB diffuse field. Immutable after construction, shared between
/// threads.
class Hrtf {
 public:
    /// Reads a SOFA file; an empty path means libmysofa's default (MIT KEMAR). Throws
    /// AudioInputError; AudioFailure where the process that reads it cannot be started.
    Hrtf(const std::filesystem::path& sofa_file, double sample_rate_hz);

    /// Takes what was measured. Throws AudioInputError for values that no measurement has.
    Hrtf(const HeadMeasurements& measured, double sample_rate_hz);
    ~Hrtf();

    struct Ear {
        std::vector<float> minimum_phase;  ///< taps() samples
        double delay_s = 0;                ///< >= 0, relative to the earlier ear of any direction
    };

    /// Both ears (left, right) for a direction in head axes (x front, y left, z up); nearest
    /// measured directions interpolated. Allocates. [propagation thread]
    std::array<Ear, 2> ears(const std::array<float, 3>& direction) const;

    /// The same into filters of taps() samples that are there; delays in s. [audio thread,
    /// wait-free]
    void ears(const std::array<float, 3>& direction,
              const std::array<std::span<float>, 2>& minimum_phase,
              std::array<double, 2>& delays_s) const noexcept AULA_NONBLOCKING;

    std::size_t taps() const;

    /// The measured responses behind it all.
    const HeadResponses& responses() const;

 private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace aula
