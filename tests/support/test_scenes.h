#pragma once

#include "aula/engine/scene.h"

namespace aula::test {

/// A source of a unit impulse and a listener at the origin that faces +x, in free field without air
/// absorption.
inline Scene free_field(const Vec3& source) {
    Scene scene;
    scene.medium.air_absorption = false;
    scene.sources.resize(1);
    scene.sources[0].name = "source";
    scene.sources[0].position = source;
    return scene;
}

/// A closed room of 5 x 4 x 3 m with absorption 0.3 and scattering 0.5, for rays alone.
inline Scene small_room() {
    Scene scene = free_field({1.2F, 1.1F, 1.5F});
    scene.listener.pose.position = {3.7F, 2.9F, 1.2F};
    scene.materials.push_back({"wall", Bands::filled(0.3F), Bands::filled(0.5F)});
    Object box;
    for (unsigned corner = 0; corner < 8; ++corner)
        box.vertices.push_back(
            {(corner & 1U) ? 5 : 0, (corner & 2U) ? 4 : 0, (corner & 4U) ? 3 : 0});
    box.triangles = {{0, 1, 3}, {0, 3, 2}, {4, 6, 7}, {4, 7, 5}, {0, 4, 5}, {0, 5, 1},
                     {2, 3, 7}, {2, 7, 6}, {0, 2, 6}, {0, 6, 4}, {1, 5, 7}, {1, 7, 3}};
    box.triangle_materials.assign(box.triangles.size(), 0);
    scene.objects.push_back(box);
    scene.simulation.ir_length_s = 0.4F;
    scene.simulation.waves_hz = 0;
    return scene;
}

}  // namespace aula::test
