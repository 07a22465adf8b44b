#include "engine/mesh_import.h"

#include <algorithm>
#include <cctype>

#include "engine/error.h"
#include "engine/mesh_readers.h"
#include "engine/names.h"
#include "engine/regular_file.h"

namespace aula {

ImportedMesh import_mesh(const std::filesystem::path& file) {
    std::string extension = file.extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    const auto bytes = [&] { return read_regular_file(file, kMostMeshBytes); };
    if (extension == ".obj") return read_obj(bytes());
    if (extension == ".ply") return read_ply(bytes());
    if (extension == ".stl") return read_stl(bytes());
    if (extension == ".gltf" || extension == ".glb") {
        return read_gltf(bytes(), [&](const std::filesystem::path& buffer) {
            return read_regular_file(file.parent_path() / buffer, kMostMeshBytes);
        });
    }
    throw Error("files of the type " + aula::quoted(extension) +
                " are not read; expected OBJ, glTF, GLB, PLY or STL");
}

}  // namespace aula
