#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

namespace aula::test {

/// Four corners of a unit square as floats, then the indices 0 1 2 0 2 3 as 16 bits.
inline std::string square_bytes() {
    const float corners[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
    const std::uint16_t indices[] = {0, 1, 2, 0, 2, 3};
    std::string bytes(reinterpret_cast<const char*>(corners), sizeof corners);
    return bytes.append(reinterpret_cast<const char*>(indices), sizeof indices);
}

/// A scene with one node: the square of material "stone", with its bytes in "square.bin".
inline nlohmann::json square_gltf() {
    return nlohmann::json::parse(R"({"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}], "materials": [{"name": "stone"}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
                      {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"}],
        "bufferViews": [{"buffer": 0, "byteLength": 48},
                        {"buffer": 0, "byteOffset": 48, "byteLength": 12}],
        "buffers": [{"byteLength": 60, "uri": "square.bin"}]})");
}

}  // namespace aula::test
