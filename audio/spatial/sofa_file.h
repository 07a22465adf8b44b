#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <vector>

namespace aula {

/// Head-related impulse responses as they were measured. [response] = direction * 2 + ear (left,
/// right).
struct HeadMeasurements {
    std::filesystem::path file;  ///< for messages
    float sample_rate_hz = 48000;
    std::size_t samples = 0;                      ///< of each response
    std::vector<std::array<float, 3>> positions;  ///< of the source; x front, y left, z up
    std::vector<float> responses;                 ///< [response * samples + sample]
    std::vector<float> delays_samples;            ///< [response], in samples of the file
};

/// The greatest sizes that are taken: of the responses before resampling, and of one.
inline constexpr std::size_t kMostDirections = 65536;
inline constexpr std::size_t kMostResponseSamples = std::size_t{1} << 25;
inline constexpr std::size_t kLongestResponse_samples = 32768;

/// Reads a SOFA file (SimpleFreeFieldHRIR) in a child process with limits on memory and time, since
/// libmysofa's parser loops on some broken files. The values are as in the file and may be any.
/// Throws AudioInputError; AudioFailure where no process can be started.
HeadMeasurements read_sofa(const std::filesystem::path& file);

}  // namespace aula
