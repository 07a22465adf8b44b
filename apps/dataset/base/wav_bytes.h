#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace aula {

/// A WAV file of 32-bit floating point in memory, [channel][sample]. All channels have the same
/// length, and there is at least one. Throws InputError for more than 4 GiB, the limit of WAV.
std::string wav_bytes(const std::vector<std::vector<float>>& channels, int sample_rate_hz);

/// The samples in each channel of a file of wav_bytes() by its size; 0 if it has another size.
std::uint64_t wav_length(std::uint64_t size, std::size_t channels);

/// Whether bytes are a file of wav_bytes() with these sizes, and all samples are finite.
bool is_wav(std::string_view bytes, std::size_t channels, std::uint64_t samples,
            int sample_rate_hz);

/// The channels of a file for which is_wav() holds, [channel][sample].
std::vector<std::vector<float>> wav_channels(std::string_view bytes, std::size_t channels);

}  // namespace aula
