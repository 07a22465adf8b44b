#include "tests/fuzz/mesh_target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    return aula::test::read_any_mesh(data, size, aula::read_obj);
}
