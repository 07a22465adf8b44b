#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "aula/engine/scene.h"
#include "tests/support/rooms.h"
#include "tests/support/statistics.h"

namespace aula::test {

/// A quadrilateral of one material.
inline Object quad(const std::vector<Vec3>& corners, std::uint32_t material) {
    Object object;
    object.vertices = corners;
    object.triangles = {{0, 1, 2}, {0, 2, 3}};
    object.triangle_materials = {material, material};
    return object;
}

inline Object partition_at(float x_m, std::uint32_t material) {
    return quad({{x_m, 0, 0}, {x_m, 4, 0}, {x_m, 4, 3}, {x_m, 0, 3}}, material);
}

/// A row of rooms of 5 x 4 x 3 m, all of one material; the source is in the first. Partitions are
/// to be added.
inline Scene row_of_rooms(int count, float absorption, float scattering) {
    Scene scene = grey_room(box(Vec3(5 * static_cast<float>(count), 4, 3)), absorption, scattering,
                            Vec3(1.2F, 1.1F, 1.5F), Vec3(7.3F, 2.9F, 1.2F));
    scene.simulation.seed = test_seed();
    return scene;
}

/// Adds a partition with a sound reduction, or an opaque one, at x.
inline void add_partition(Scene& scene, float x_m, std::optional<float> reduction_db) {
    Material material = scene.materials[0];
    material.name = "partition";
    if (reduction_db) material.sound_reduction_db = Bands::filled(*reduction_db);
    scene.materials.push_back(material);
    scene.objects.push_back(
        partition_at(x_m, static_cast<std::uint32_t>(scene.materials.size()) - 1));
}

}  // namespace aula::test
