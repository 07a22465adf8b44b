#include "tests/fuzz/directivity_target.h"

using namespace aula;

/// The input is a directivity in JSON.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const auto file = test::input_file("horn.json", data, size);
    return test::make_any_directivity([&] { return load_directivity(file); });
}
