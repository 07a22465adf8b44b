#include "engine/process/contained_process.h"

#include <catch2/catch.hpp>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

namespace {

std::vector<std::byte> bytes_of(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    const std::vector<char> read{std::istreambuf_iterator<char>(in), {}};
    const auto* first = reinterpret_cast<const std::byte*>(read.data());
    return {first, first + read.size()};
}

}  // namespace

TEST_CASE("an answer that ends early is reported when the program ends, not at its deadline") {
    const std::vector<std::byte> program = bytes_of("/bin/echo");
    if (program.empty()) {
        WARN("skipped: there is no /bin/echo");
        return;
    }
    // The program answers with the end of a line, and ends.
    aula::ContainedProcess process(program, AULA_SOURCE_DIR "/LICENSE", "a file");
    const auto begin = std::chrono::steady_clock::now();
    char line_end = 0;
    CHECK(process.read(line_end));
    CHECK(line_end == '\n');
    double value = 0;
    CHECK_FALSE(process.read(value));
    // The deadline is 60 s.
    CHECK(std::chrono::steady_clock::now() - begin < std::chrono::seconds(20));
}
