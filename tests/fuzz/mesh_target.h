#pragma once

#include <cmath>
#include <string_view>

#include "aula/exception.h"
#include "engine/mesh/mesh_readers.h"
#include "tests/fuzz/fuzz_target.h"

namespace aula::test {

/// Reads a mesh from any bytes. It must be usable, or be refused with one line.
template <class Read>
int read_any_mesh(const std::uint8_t* data, std::size_t size, const Read& read) {
    try {
        const ImportedMesh mesh = read(std::string_view(reinterpret_cast<const char*>(data), size));
        expect(!mesh.triangles.empty(), "a mesh has triangles");
        expect(mesh.triangles.size() == mesh.triangle_materials.size(), "one material a triangle");
        for (const Vec3& v : mesh.vertices) {
            expect(std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z),
                   "vertices are finite");
        }
        for (const auto& triangle : mesh.triangles) {
            for (const std::uint32_t index : triangle) {
                expect(index < mesh.vertices.size(), "corners are vertices");
            }
        }
        for (const std::uint32_t material : mesh.triangle_materials) {
            expect(material < mesh.material_names.size(), "materials have names");
        }
    } catch (const InputError& error) {
        expect_one_line(error.what());
    }
    return 0;
}

}  // namespace aula::test
