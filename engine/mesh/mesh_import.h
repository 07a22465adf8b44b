#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "engine/base/vec3.h"

namespace aula {

/// The triangles of a mesh file with its node transforms applied, in the file's own axes and
/// units. Triangles without area, points and lines are left out.
struct ImportedMesh {
    std::vector<Vec3> vertices;
    std::vector<std::array<std::uint32_t, 3>> triangles;
    std::vector<std::uint32_t> triangle_materials;  ///< index into material_names
    std::vector<std::string> material_names;        ///< as the file calls them, each once
    std::vector<std::filesystem::path> files;       ///< that were read
};

/// What a mesh file may hold at most.
inline constexpr std::uint64_t kMostMeshBytes = std::uint64_t{1} << 30;
inline constexpr std::uint64_t kMostMeshTriangles = 20'000'000;

/// The name of the material of faces for which the file names none.
inline constexpr const char* kNamelessMaterial = "DefaultMaterial";

/// Reads OBJ, glTF, GLB, PLY or STL, by the file's extension. The file may be hostile: it is
/// bounded in size, checked index by index, and never waited for. Throws Error whose message is
/// "what is wrong; what was expected".
ImportedMesh import_mesh(const std::filesystem::path& file);

}  // namespace aula
