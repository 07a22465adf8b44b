#include "engine/mesh_import.h"

#include <assimp/scene.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <cmath>
#include <fstream>
#include <glm/geometric.hpp>
#include <utility>

#include "engine/error.h"
#include "engine/polygon.h"

namespace aula {
namespace {

using Triangle = std::array<std::uint32_t, 3>;

// The importer waits for ever for the end of a PLY file's header.
void check_ply_header(const std::filesystem::path& file) {
    const std::string kEnd = "end_header";
    std::ifstream stream(file, std::ios::binary);
    std::string line;  // or all lines, where a carriage return ends them
    std::getline(stream, line);
    if (line.substr(0, 3) != "ply") return;
    do {
        const std::size_t begin = line.find(kEnd);
        if (begin == std::string::npos) continue;
        const std::size_t end = begin + kEnd.size();
        const bool starts_line = begin == 0 || line[begin - 1] == '\r';
        const bool ends_line = end == line.size() || line[end] == '\r' || line[end] == ' ';
        if (starts_line && ends_line) return;
    } while (std::getline(stream, line));
    throw Error("a PLY file without end_header");
}

// The height over the longest side is below the rounding of the coordinates.
bool has_no_area(const Vec3& a, const Vec3& b, const Vec3& c) {
    const glm::dvec3 ab = glm::dvec3(b) - glm::dvec3(a);
    const glm::dvec3 ac = glm::dvec3(c) - glm::dvec3(a);
    const glm::dvec3 bc = ac - ab;
    const double longest = std::max({glm::dot(ab, ab), glm::dot(ac, ac), glm::dot(bc, bc)});
    return glm::length(glm::cross(ab, ac)) <= 1e-7 * longest;
}

// A face of more than 3 corners as triangles; as a fan if it cannot be cut properly. The importer
// can do this, too, but ends the program on some malformed faces.
std::vector<Triangle> triangles_of(const std::vector<std::uint32_t>& face,
                                   const std::vector<Vec3>& vertices) {
    std::vector<Vec3> corners;
    for (const std::uint32_t index : face) corners.push_back(vertices[index]);
    std::vector<Triangle> triangles;
    for (const auto& [a, b, c] : triangulate(corners)) {
        triangles.push_back({face[a], face[b], face[c]});
    }
    if (!triangles.empty()) return triangles;
    for (std::size_t i = 1; i + 1 < face.size(); ++i) {
        triangles.push_back({face[0], face[i], face[i + 1]});
    }
    return triangles;
}

// Index of each of the importer's materials among the distinct names.
std::vector<std::uint32_t> material_indices(const aiScene& scene, ImportedMesh& mesh) {
    std::vector<std::uint32_t> indices;
    for (unsigned i = 0; i < scene.mNumMaterials; ++i) {
        const std::string name = scene.mMaterials[i]->GetName().C_Str();
        auto& names = mesh.material_names;
        const auto known = std::find(names.begin(), names.end(), name);
        indices.push_back(static_cast<std::uint32_t>(known - names.begin()));
        if (known == names.end()) names.push_back(name);
    }
    return indices;
}

void append(const aiMesh& part, const aiMatrix4x4& transform, std::uint32_t material,
            ImportedMesh& mesh) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    for (unsigned i = 0; i < part.mNumVertices; ++i) {
        const aiVector3D v = transform * part.mVertices[i];
        if (!std::isfinite(v.x) || !std::isfinite(v.y) || !std::isfinite(v.z)) {
            throw Error("vertex " + std::to_string(first + i) + " is not finite");
        }
        mesh.vertices.emplace_back(v.x, v.y, v.z);
    }
    const auto add = [&](const Triangle& t) {
        const auto& v = mesh.vertices;
        if (has_no_area(v[t[0]], v[t[1]], v[t[2]])) return;
        mesh.triangles.push_back(t);
        mesh.triangle_materials.push_back(material);
    };
    std::vector<std::uint32_t> face;
    for (unsigned i = 0; i < part.mNumFaces; ++i) {
        const aiFace& indices = part.mFaces[i];
        face.clear();
        for (unsigned corner = 0; corner < indices.mNumIndices; ++corner) {
            if (indices.mIndices[corner] >= part.mNumVertices) {
                throw Error("face " + std::to_string(i) + " names vertex " +
                            std::to_string(indices.mIndices[corner]) + " of " +
                            std::to_string(part.mNumVertices));
            }
            face.push_back(first + indices.mIndices[corner]);
        }
        if (face.size() == 3) {
            add({face[0], face[1], face[2]});
        } else if (face.size() > 3) {
            for (const Triangle& triangle : triangles_of(face, mesh.vertices)) add(triangle);
        }
    }
}

}  // namespace

ImportedMesh import_mesh(const std::filesystem::path& file) {
    check_ply_header(file);
    Assimp::Importer importer;
    const aiScene* scene = importer.ReadFile(file.string(), 0);
    if (scene == nullptr) {
        std::string reason = importer.GetErrorString();
        std::replace(reason.begin(), reason.end(), '\n', ' ');
        throw Error(reason);
    }

    ImportedMesh mesh;
    const std::vector<std::uint32_t> materials = material_indices(*scene, mesh);
    std::vector<std::pair<const aiNode*, aiMatrix4x4>> open;
    if (scene->mRootNode != nullptr) open.emplace_back(scene->mRootNode, aiMatrix4x4());
    while (!open.empty()) {
        const auto [node, parent] = open.back();
        open.pop_back();
        const aiMatrix4x4 transform = parent * node->mTransformation;
        for (unsigned i = 0; i < node->mNumMeshes; ++i) {
            const aiMesh& part = *scene->mMeshes[node->mMeshes[i]];
            if (part.mMaterialIndex >= materials.size()) throw Error("a mesh without material");
            append(part, transform, materials[part.mMaterialIndex], mesh);
        }
        for (unsigned i = node->mNumChildren; i > 0; --i) {
            open.emplace_back(node->mChildren[i - 1], transform);
        }
    }
    if (mesh.triangles.empty()) throw Error("it holds no triangle that has an area");
    return mesh;
}

}  // namespace aula
