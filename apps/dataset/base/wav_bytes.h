#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace aula {

/// A WAV file of 32-bit floating point in memory, [channel][sample]. All channels have the same
/// length, and there is at least one.
std::string wav_bytes(const std::vector<std::vector<float>>& channels, int sample_rate_hz);

/// The channels of a file of wav_bytes(), [channel][sample]. Throws InputError for other content.
std::vector<std::vector<float>> wav_channels(std::string_view bytes);

/// The length of a file of wav_bytes() with `size` bytes in samples of each channel.
std::size_t wav_length(std::size_t size, std::size_t channels);

}  // namespace aula
