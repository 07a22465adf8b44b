#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace aula::test {

/// A random valid scene, its command line and the expected results.
struct MatrixCase {
    std::vector<std::string> command;  ///< "aula", then arguments
    double sample_rate_hz = 48000;
    int channels = 2;
    double duration_s = 0;  ///< exact if given, else the least
    bool duration_given = true;
    double longest_s = 0;        ///< upper limit if the duration is not given
    bool must_be_heard = false;  ///< direct sound arrives in the first half
    double cpu_limit_s = 0;      ///< CPU time
};

/// Makes a case that depends on the seed only. Writes the scene and its sounds to the folder.
MatrixCase make_case(std::uint64_t seed, const std::filesystem::path& folder);

}  // namespace aula::test
