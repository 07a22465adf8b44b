#pragma once

#include <array>
#include <cstddef>

namespace aula {

/// What a listener's output is.
enum class OutputFormat {
    binaural,  ///< two channels for headphones, left and right, with the head's orientation
    mono,      ///< one channel: the sound pressure at the listener
    foa,       ///< four channels: first-order ambisonics, AmbiX (ACN, SN3D: W Y Z X), head axes
    toa        ///< 16 channels: third-order ambisonics, AmbiX (ACN, SN3D), head axes
};

/// An output format and its name on the command line, in datasets and in Python.
struct OutputFormatName {
    const char* name;     ///< "binaural", "mono", "foa", "toa"
    OutputFormat format;  ///< of this name
};

/// The names of all output formats.
inline constexpr std::array<OutputFormatName, 4> kOutputFormats{
    {{"binaural", OutputFormat::binaural},
     {"mono", OutputFormat::mono},
     {"foa", OutputFormat::foa},
     {"toa", OutputFormat::toa}}};

/// Number of channels of an output format: 2, 1, 4 or 16.
std::size_t channel_count(OutputFormat format);

}  // namespace aula
