#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace aula::test {

/// A random valid scene, the command line that runs it, and what has to come of it.
struct MatrixCase {
    std::vector<std::string> command;  ///< "aula", then arguments; files are in the case's folder
    double sample_rate_hz = 48000;
    int channels = 2;
    double duration_s = 0;  ///< of rendering and playing: exactly, if given; else at least
    bool duration_given = true;
    double longest_s = 0;        ///< at most, where the duration is not given
    bool must_be_heard = false;  ///< direct sound arrives before half of the duration is over
    double cpu_limit_s = 0;      ///< of one core
};

/// The same case for the same seed. Writes the scene and its sounds to the folder.
MatrixCase make_case(std::uint64_t seed, const std::filesystem::path& folder);

}  // namespace aula::test
