#include <cstring>

#include "tests/fuzz/directivity_target.h"

using namespace aula;

/// The input is a directivity in JSON, or a SOFA file, which a child process reads.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    constexpr char kHdf5[] = "\x89HDF";
    const bool is_sofa = size >= 4 && std::memcmp(data, kHdf5, 4) == 0;
    const auto file = test::input_file(is_sofa ? "horn.sofa" : "horn.json", data, size);
    return test::make_any_directivity([&] { return load_directivity(file); });
}
