#pragma once

#include <cstddef>

namespace aula {

/// What a listener's output is: two ears, omnidirectional pressure, or first-order ambisonics
/// (AmbiX: ACN, SN3D).
enum class OutputFormat { binaural, mono, foa };

/// Channels of an output format: 2, 1, 4.
std::size_t channel_count(OutputFormat format);

}  // namespace aula
