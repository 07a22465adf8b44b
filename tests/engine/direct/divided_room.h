#pragma once

#include <algorithm>
#include <iterator>
#include <vector>

#include "aula/engine/propagation.h"

namespace aula::test {

inline const Vec3 kSource(1, 1, 1.5F);
inline const Vec3 kBehindWall(5, 1.2F, 1.5F);
inline const Vec3 kInSight(2, 3, 1.5F);

/// A closed box of 6 x 4 x 3 m, and a thin wall at x = 3 m from y = 0 to y = 2.6 m.
inline Scene divided_room() {
    Scene scene;
    Object box;
    for (int i = 0; i < 8; ++i) {
        box.vertices.emplace_back((i & 1) != 0 ? 6 : 0, (i & 2) != 0 ? 4 : 0, (i & 4) != 0 ? 3 : 0);
    }
    const auto add_quad = [](Object& object, std::uint32_t a, std::uint32_t b, std::uint32_t c,
                             std::uint32_t d) {
        object.triangles.push_back({a, b, c});
        object.triangles.push_back({a, c, d});
        object.triangle_materials.insert(object.triangle_materials.end(), 2, 0);
    };
    add_quad(box, 0, 1, 3, 2);
    add_quad(box, 4, 6, 7, 5);
    add_quad(box, 0, 4, 5, 1);
    add_quad(box, 2, 3, 7, 6);
    add_quad(box, 0, 2, 6, 4);
    add_quad(box, 1, 5, 7, 3);
    Object wall;
    wall.vertices = {{3, 0, 0}, {3, 2.6F, 0}, {3, 2.6F, 3}, {3, 0, 3}};
    add_quad(wall, 0, 1, 2, 3);
    scene.objects = {box, wall};
    scene.materials = {{"wall", Bands::filled(0.3F), Bands::filled(0.5F)}};
    scene.sources.emplace_back();
    scene.sources[0].position = kSource;
    scene.listener.pose.position = kBehindWall;
    scene.simulation.ir_length_s = 0.2F;
    scene.simulation.rays = 1;
    scene.simulation.threads = 2;
    return scene;
}

inline std::vector<SoundPath> direct_of(const EnergyResponse& response) {
    std::vector<SoundPath> direct;
    std::copy_if(response.paths.begin(), response.paths.end(), std::back_inserter(direct),
                 [](const SoundPath& path) { return path.order == 0; });
    return direct;
}

inline Bands energy_of(const std::vector<SoundPath>& paths) {
    Bands sum;
    for (const SoundPath& path : paths) sum += path.energy;
    return sum;
}

inline std::vector<SoundPath> direct_of_frame_1(const Scene& scene, const Vec3& listener) {
    Propagation propagation(scene, scene.simulation);
    propagation.step({.sources = {kSource}, .listeners = {listener}});
    return direct_of(propagation.response(0));
}

/// The key of the main path also tells whether it has jumped before.
inline bool same(const SoundPath& a, const SoundPath& b) {
    return a.length_m == b.length_m && a.direction == b.direction && a.energy == b.energy &&
           a.is_main == b.is_main && (a.is_main || a.key == b.key) && a.edges == b.edges;
}

}  // namespace aula::test
