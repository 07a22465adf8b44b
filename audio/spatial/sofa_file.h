#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <vector>

namespace aula {

/// Measured head-related impulse responses. Response index: direction * 2 + ear (left, right).
struct HeadMeasurements {
    std::filesystem::path file;  ///< for messages
    float sample_rate_hz = 48000;
    std::size_t samples = 0;                      ///< length of a response
    std::vector<std::array<float, 3>> positions;  ///< of the source, m; x front, y left, z up
    std::vector<float> responses;                 ///< [response * samples + sample]
    std::vector<float> delays_samples;            ///< [response], at the file's sample rate
};

/// Limits of a file: directions, samples of all responses, samples of one response.
inline constexpr std::size_t kMaxDirections = 65536;
inline constexpr std::size_t kMaxResponseSamples = std::size_t{1} << 25;
inline constexpr std::size_t kLongestResponse_samples = 32768;

/// Reads a SOFA file (SimpleFreeFieldHRIR) in a child process with limits on memory and time:
/// libmysofa's parser does not terminate on some damaged files. The values are not checked. Throws
/// InputError, or Failure if the process cannot be started.
HeadMeasurements read_sofa(const std::filesystem::path& file);

}  // namespace aula
