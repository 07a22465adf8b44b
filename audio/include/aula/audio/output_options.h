#pragma once

#include <filesystem>

#include "aula/audio/output_format.h"

namespace aula {

/// How the sound at a listener is rendered.
struct OutputOptions {
    double sample_rate_hz = 48000;  ///< of inputs and outputs, 8000 to 384000
    /// Largest number of samples that are processed together, 1 to 8192, best the size of most
    /// calls. Longer calls are divided; shorter ones cost more per sample.
    int block = 256;
    OutputFormat output = OutputFormat::binaural;  ///< of each listener
    int ambisonic_order = 1;           ///< of the reverberation in binaural output, 1 to 3
    bool half_precision_tail = false;  ///< late reverberation in half the memory, error -74 dB
    std::filesystem::path hrtf{};      ///< SOFA file for binaural output; empty: MIT KEMAR
    /// Sound file of an impulse response of at most 4 s with which binaural output is convolved:
    /// one channel for both ears, or left and right; 1.0 is the gain 1, at any sample rate. Empty:
    /// none.
    std::filesystem::path headphones{};
};

}  // namespace aula
