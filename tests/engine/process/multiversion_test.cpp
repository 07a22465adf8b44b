#include "engine/process/multiversion.h"

#include <array>
#include <catch2/catch.hpp>
#include <cstddef>
#include <fstream>
#include <sstream>
#include <string>

using aula::InstructionSet;
using aula::kBestInstructionSet;

namespace {

constexpr std::size_t kCount = 37;  // not a multiple of the lanes of any vector
using Numbers = std::array<float, kCount>;

AULA_MULTIVERSION
float add_squares(const Numbers& in, Numbers& sums) {
    for (std::size_t i = 0; i < kCount; ++i) sums[i] += in[i] * in[i];
    return sums[kCount - 1];
}

AULA_MULTIVERSION
void throw_value(int value) { throw value; }

#if defined(__x86_64__)
/// What the kernel says of the first processor, between spaces.
std::string processor_flags() {
    std::ifstream information("/proc/cpuinfo");
    for (std::string line; std::getline(information, line);)
        if (line.starts_with("flags")) return line + " ";
    return {};
}

bool has_all(const std::string& flags, const std::string& wanted) {
    std::istringstream words(wanted);
    for (std::string word; words >> word;)
        if (flags.find(" " + word + " ") == std::string::npos) return false;
    return true;
}
#endif

}  // namespace

TEST_CASE("The instruction set is the largest one that the kernel reports") {
    InstructionSet expected = InstructionSet::kPortable;
#if defined(__x86_64__)
    const std::string flags = processor_flags();
    if (has_all(flags, "avx2 bmi1 bmi2 f16c fma popcnt")) {
        expected = InstructionSet::kAvx2;
        if (has_all(flags, "avx512bw avx512cd avx512dq avx512f avx512vl"))
            expected = InstructionSet::kAvx512;
    }
#endif
    CHECK(kBestInstructionSet == expected);
}

TEST_CASE("The versions of a function for all instruction sets agree") {
    for (const auto set :
         {InstructionSet::kPortable, InstructionSet::kAvx2, InstructionSet::kAvx512}) {
        if (set > kBestInstructionSet) continue;
        Numbers in;
        Numbers sums{};
        for (std::size_t i = 0; i < kCount; ++i) in[i] = static_cast<float>(i);
        aula::Versions<add_squares>::call(set, in, sums);
        CHECK(aula::Versions<add_squares>::call(set, in, sums) == 2 * 36 * 36);
        for (std::size_t i = 0; i < kCount; ++i) CHECK(sums[i] == 2 * in[i] * in[i]);
    }
}

TEST_CASE("Exceptions of a version reach its caller") {
    CHECK_THROWS_AS(aula::best_version<throw_value>(1), int);
}
