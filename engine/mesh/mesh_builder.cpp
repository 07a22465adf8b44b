#include "engine/mesh/mesh_builder.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <utility>

#include "aula/exception.h"
#include "engine/base/tolerances.h"
#include "engine/mesh/polygon.h"

namespace aula {
namespace {

// True if the height over the longest side is below the rounding of the coordinates.
bool has_no_area(const Vec3& a, const Vec3& b, const Vec3& c) {
    const glm::dvec3 ab = glm::dvec3(b) - glm::dvec3(a);
    const glm::dvec3 ac = glm::dvec3(c) - glm::dvec3(a);
    const glm::dvec3 bc = ac - ab;
    const double longest = std::max({glm::dot(ab, ab), glm::dot(ac, ac), glm::dot(bc, bc)});
    return glm::length(glm::cross(ab, ac)) <= tolerances::kNoHeight * longest;
}

// Bounds memory: a glTF file can instance the same triangles any number of times.
void check_count(std::uint64_t triangles) {
    if (triangles > kMaxMeshTriangles) {
        throw InputError("more than " + std::to_string(kMaxMeshTriangles) +
                         " triangles; expected a smaller mesh");
    }
}

}  // namespace

std::uint32_t MeshBuilder::material(const std::string& name) {
    const auto next = static_cast<std::uint32_t>(mesh_.material_names.size());
    const auto [entry, added] = materials_.try_emplace(name, next);
    if (added) mesh_.material_names.push_back(name);
    return entry->second;
}

void MeshBuilder::add_vertex(double x, double y, double z) {
    const Vec3 vertex(x, y, z);
    if (!std::isfinite(vertex.x) || !std::isfinite(vertex.y) || !std::isfinite(vertex.z)) {
        throw InputError("vertex " + std::to_string(vertex_count() + 1) +
                         " is not finite; expected finite coordinates");
    }
    check_count(vertex_count() / 3);
    mesh_.vertices.push_back(vertex);
}

void MeshBuilder::add_face(std::span<const std::uint32_t> corners, std::uint32_t material) {
    if (corners.size() > kMaxCorners) {
        throw InputError("face " + std::to_string(face_ends_.size() + 1) + " has " +
                         std::to_string(corners.size()) + " corners; expected at most " +
                         std::to_string(kMaxCorners));
    }
    if (corners.size() < 3) return;
    corners_.insert(corners_.end(), corners.begin(), corners.end());
    face_ends_.push_back(corners_.size());
    face_materials_.push_back(material);
    check_count(corners_.size() - 2 * face_ends_.size());
}

void MeshBuilder::add_triangle(const std::array<std::uint32_t, 3>& corners,
                               std::uint32_t material) {
    const auto& v = mesh_.vertices;
    if (has_no_area(v[corners[0]], v[corners[1]], v[corners[2]])) return;
    mesh_.triangles.push_back(corners);
    mesh_.triangle_materials.push_back(material);
}

// Triangulates a face of more than 3 corners, as a fan if ear clipping fails.
void MeshBuilder::cut(std::span<const std::uint32_t> face, std::uint32_t material) {
    std::vector<Vec3> corners;
    for (const std::uint32_t index : face) corners.push_back(mesh_.vertices[index]);
    const auto triangles = triangulate(corners);
    for (const auto& [a, b, c] : triangles) add_triangle({face[a], face[b], face[c]}, material);
    if (!triangles.empty()) return;
    for (std::size_t i = 1; i + 1 < face.size(); ++i) {
        add_triangle({face[0], face[i], face[i + 1]}, material);
    }
}

ImportedMesh MeshBuilder::take() {
    const std::size_t count = vertex_count();
    std::size_t begin = 0;
    for (std::size_t i = 0; i < face_ends_.size(); ++i) {
        const std::span face(corners_.data() + begin, face_ends_[i] - begin);
        begin = face_ends_[i];
        for (const std::uint32_t index : face) {
            if (index >= count) {
                throw InputError("face " + std::to_string(i + 1) + " refers to vertex " +
                                 std::to_string(std::uint64_t{index} + 1) + " of " +
                                 std::to_string(count) + "; expected vertices that exist");
            }
        }
        if (face.size() == 3) {
            add_triangle({face[0], face[1], face[2]}, face_materials_[i]);
        } else {
            cut(face, face_materials_[i]);
        }
    }
    if (mesh_.triangles.empty()) {
        throw InputError("it holds no triangle that has an area; expected at least one");
    }
    return std::move(mesh_);
}

}  // namespace aula
