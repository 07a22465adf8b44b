#include <string>

#include "tests/fuzz/mesh_target.h"

/// glTF or GLB, and its first sound; every buffer's file holds a triangle and its indices.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const auto open = [](const std::filesystem::path& file) {
        if (file == "none.bin")
            throw aula::InputError("it cannot be opened; expected a readable file");
        const float corners[] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
        return std::string(reinterpret_cast<const char*>(corners), sizeof corners) +
               std::string("\0\0\1\0\2\0", 6);
    };
    return aula::test::read_any_mesh(data, size, [&](std::string_view bytes) {
        try {
            aula::read_gltf_sound(bytes, 0, open);
        } catch (const aula::InputError&) {
        }
        return aula::read_gltf(bytes, open);
    });
}
