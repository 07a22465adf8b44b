#include "tests/fuzz/hrtf_target.h"

/// The file goes through the child process that reads SOFA.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    return aula::test::make_any_hrtf(aula::test::input_file("set.sofa", data, size));
}
