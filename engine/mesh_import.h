#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "engine/scene.h"

namespace aula {

/// The triangles of a mesh file with its node transforms applied, in the file's own axes and
/// units. Triangles without area, points and lines are left out.
struct ImportedMesh {
    std::vector<Vec3> vertices;
    std::vector<std::array<std::uint32_t, 3>> triangles;
    std::vector<std::uint32_t> triangle_materials;  ///< index into material_names
    std::vector<std::string> material_names;        ///< as the file calls them, each once
};

/// Reads OBJ, glTF, GLB, PLY, STL and whatever else the importer knows. Throws Error whose message
/// is the bare reason: unreadable, a vertex that is not finite, an index out of range, no triangle.
ImportedMesh import_mesh(const std::filesystem::path& file);

}  // namespace aula
