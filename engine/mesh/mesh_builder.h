#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "engine/mesh/mesh_import.h"

namespace aula {

/// Builds a mesh from vertices and faces of a file, checks them and triangulates the faces. A face
/// may precede its vertices. All functions throw InputError if a limit of mesh_import.h is
/// exceeded.
class MeshBuilder {
 public:
    /// Index of a material name, which is added if new.
    std::uint32_t material(const std::string& name);

    /// Adds a vertex. Throws InputError if it is not finite in single precision.
    void add_vertex(double x, double y, double z);
    std::size_t vertex_count() const { return mesh_.vertices.size(); }

    /// Adds a polygon; fewer than 3 corners are ignored.
    void add_face(std::span<const std::uint32_t> corners, std::uint32_t material);

    bool has_faces() const { return !face_ends_.empty(); }

    /// Returns the mesh. Throws InputError if an index is out of range or no triangle has an area.
    ImportedMesh take();

 private:
    void cut(std::span<const std::uint32_t> face, std::uint32_t material);
    void add_triangle(const std::array<std::uint32_t, 3>& corners, std::uint32_t material);

    ImportedMesh mesh_;
    std::unordered_map<std::string, std::uint32_t> materials_;
    std::vector<std::uint32_t> corners_;  // of all faces
    std::vector<std::size_t> face_ends_;  // in corners_
    std::vector<std::uint32_t> face_materials_;
};

}  // namespace aula
