#include "engine/mesh_import.h"

#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <cmath>
#include <glm/geometric.hpp>
#include <utility>

#include "engine/error.h"

namespace aula {
namespace {

// The height over the longest side is below the rounding of the coordinates.
bool has_no_area(const Vec3& a, const Vec3& b, const Vec3& c) {
    const glm::dvec3 ab = glm::dvec3(b) - glm::dvec3(a);
    const glm::dvec3 ac = glm::dvec3(c) - glm::dvec3(a);
    const glm::dvec3 bc = ac - ab;
    const double longest = std::max({glm::dot(ab, ab), glm::dot(ac, ac), glm::dot(bc, bc)});
    return glm::length(glm::cross(ab, ac)) <= 1e-7 * longest;
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
    for (unsigned i = 0; i < part.mNumFaces; ++i) {
        const aiFace& face = part.mFaces[i];
        if (face.mNumIndices != 3) continue;
        std::array<std::uint32_t, 3> triangle{};
        for (unsigned corner = 0; corner < 3; ++corner) {
            if (face.mIndices[corner] >= part.mNumVertices) {
                throw Error("face " + std::to_string(i) + " names vertex " +
                            std::to_string(face.mIndices[corner]) + " of " +
                            std::to_string(part.mNumVertices));
            }
            triangle[corner] = first + face.mIndices[corner];
        }
        if (has_no_area(mesh.vertices[triangle[0]], mesh.vertices[triangle[1]],
                        mesh.vertices[triangle[2]])) {
            continue;
        }
        mesh.triangles.push_back(triangle);
        mesh.triangle_materials.push_back(material);
    }
}

}  // namespace

ImportedMesh import_mesh(const std::filesystem::path& file) {
    Assimp::Importer importer;
    const aiScene* scene = importer.ReadFile(file.string(), aiProcess_Triangulate);
    if (scene == nullptr) throw Error(importer.GetErrorString());

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
            append(part, transform, materials.at(part.mMaterialIndex), mesh);
        }
        for (unsigned i = node->mNumChildren; i > 0; --i) {
            open.emplace_back(node->mChildren[i - 1], transform);
        }
    }
    if (mesh.triangles.empty()) throw Error("it holds no triangle that has an area");
    return mesh;
}

}  // namespace aula
