#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string_view>

#include "tests/support/temporary_folder.h"

/// Reads one input; called by libFuzzer, or by replay.cpp for each file of a corpus.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace aula::test {

/// The folder in which a target writes its inputs; removed when the program ends.
inline const TemporaryFolder& fuzz_folder() {
    static const TemporaryFolder folder;
    return folder;
}

/// The input as a file of that name in fuzz_folder(), for readers of files.
inline std::filesystem::path input_file(const char* name, const std::uint8_t* data,
                                        std::size_t size) {
    return fuzz_folder().write(name, std::string(reinterpret_cast<const char*>(data), size));
}

/// Ends the program if a condition that must hold for any input is false.
inline void expect(bool holds, const char* claim) {
    if (holds) return;
    std::fprintf(stderr, "does not hold: %s\n", claim);
    std::abort();
}

/// A message is one line.
inline void expect_one_line(std::string_view message) {
    expect(!message.empty() && message.find('\n') == std::string_view::npos,
           "a message is one line");
}

}  // namespace aula::test
