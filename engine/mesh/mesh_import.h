#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "aula/engine/vec3.h"

namespace aula {

/// The triangles of a mesh file with node transforms applied, in the axes and units of the file.
/// Triangles without area, points and lines are omitted.
struct ImportedMesh {
    std::vector<Vec3> vertices;
    std::vector<std::array<std::uint32_t, 3>> triangles;
    std::vector<std::uint32_t> triangle_materials;  ///< index into material_names
    std::vector<std::string> material_names;        ///< as in the file, each once
    std::vector<std::filesystem::path> files;       ///< all files read
};

/// Limits of a mesh file.
inline constexpr std::uint64_t kMaxMeshBytes = std::uint64_t{1} << 30;
inline constexpr std::uint64_t kMaxMeshTriangles = 20'000'000;

/// The material name of faces without one.
inline constexpr const char* kNamelessMaterial = "DefaultMaterial";

/// Reads OBJ, glTF, GLB, PLY or STL according to the file's extension. The file may be malicious:
/// its size is bounded, all indices are checked and reading never blocks. Throws InputError with
/// the message "what is wrong; what was expected".
ImportedMesh import_mesh(const std::filesystem::path& file);

}  // namespace aula
