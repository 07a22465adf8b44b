#include "apps/room/edit/scene_edits.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <tuple>

#include "apps/room/frames/play_controls.h"
#include "aula/engine/material_library.h"

namespace aula {

namespace {

/// The object and the local index of a triangle that is numbered over all objects.
std::pair<std::size_t, std::size_t> locate(const Scene& scene, std::uint32_t triangle) {
    std::size_t left = triangle;
    for (std::size_t object = 0; object < scene.objects.size(); ++object) {
        if (left < scene.objects[object].triangles.size()) return {object, left};
        left -= scene.objects[object].triangles.size();
    }
    return {scene.objects.size(), 0};
}

bool same(const std::optional<Trajectory>& a, const std::optional<Trajectory>& b) {
    if (!a || !b) return !a && !b;
    return a->loop == b->loop && std::equal(a->points.begin(), a->points.end(), b->points.begin(),
                                            b->points.end(), [](const auto& p, const auto& q) {
                                                return p.time_s == q.time_s &&
                                                       same_pose(p.pose, q.pose);
                                            });
}

}  // namespace

bool same_geometry(const Scene& a, const Scene& b) {
    return std::equal(a.objects.begin(), a.objects.end(), b.objects.begin(), b.objects.end(),
                      [](const Object& o, const Object& p) {
                          return o.vertices == p.vertices && o.triangles == p.triangles &&
                                 o.translation == p.translation && same(o.path, p.path);
                      });
}

std::vector<std::uint32_t> surface_of(const RayScene& rays, std::uint32_t triangle) {
    constexpr float kSameDirection = 0.9998F;  // about a degree
    constexpr float kSamePlane_m = 0.005F;
    constexpr float kSameCorner_m = 0.001F;
    const RayScene::Triangle& picked = rays.triangle(triangle);
    const auto in_plane = [&](const RayScene::Triangle& other) {
        return other.object == picked.object && other.material == picked.material &&
               std::abs(glm::dot(other.normal, picked.normal)) > kSameDirection &&
               std::all_of(other.vertices.begin(), other.vertices.end(), [&](const Vec3& v) {
                   return std::abs(glm::dot(v - picked.vertices[0], picked.normal)) < kSamePlane_m;
               });
    };
    using Corner = std::tuple<long, long, long>;
    const auto corner = [](const Vec3& v) {
        return Corner{std::lround(v.x / kSameCorner_m), std::lround(v.y / kSameCorner_m),
                      std::lround(v.z / kSameCorner_m)};
    };
    std::map<Corner, std::vector<std::uint32_t>> at_corner;
    for (std::uint32_t t = 0; t < rays.triangle_count(); ++t) {
        if (!in_plane(rays.triangle(t))) continue;
        for (const Vec3& v : rays.triangle(t).vertices) at_corner[corner(v)].push_back(t);
    }
    std::vector<std::uint32_t> found{triangle};
    std::vector<char> seen(rays.triangle_count(), 0);
    seen[triangle] = 1;
    for (std::size_t next = 0; next < found.size(); ++next) {
        for (const Vec3& v : rays.triangle(found[next]).vertices) {
            for (const std::uint32_t t : at_corner[corner(v)]) {
                if (seen[t]) continue;
                seen[t] = 1;
                found.push_back(t);
            }
        }
    }
    std::sort(found.begin(), found.end());
    return found;
}

std::vector<std::uint32_t> triangles_like(const Scene& scene, std::uint32_t triangle) {
    const auto [object, index] = locate(scene, triangle);
    const std::uint32_t material = scene.objects[object].triangle_materials[index];
    std::vector<std::uint32_t> found;
    std::uint32_t t = 0;
    for (const Object& other : scene.objects) {
        for (const std::uint32_t of_triangle : other.triangle_materials) {
            if (of_triangle == material) found.push_back(t);
            ++t;
        }
    }
    return found;
}

const Material& material_of(const Scene& scene, std::uint32_t triangle) {
    const auto [object, index] = locate(scene, triangle);
    return scene.materials[scene.objects[object].triangle_materials[index]];
}

Scene with_material(const Scene& scene, const std::vector<std::uint32_t>& triangles,
                    const Material& material) {
    Scene edited = scene;
    Material wanted = material;
    const auto find = [&](const auto& matches) {
        return std::find_if(edited.materials.begin(), edited.materials.end(), matches);
    };
    for (int number = 2;; ++number) {
        const auto named = find([&](const Material& m) { return m.name == wanted.name; });
        if (named == edited.materials.end()) {
            edited.materials.push_back(wanted);
            break;
        }
        if (*named == wanted) break;
        wanted.name = material.name + " " + std::to_string(number);
    }
    const auto index = static_cast<std::uint32_t>(
        find([&](const Material& m) { return m.name == wanted.name; }) - edited.materials.begin());
    for (const std::uint32_t triangle : triangles) {
        const auto [object, own] = locate(edited, triangle);
        edited.objects[object].triangle_materials[own] = index;
    }
    return edited;
}

std::optional<Scene> with_material_replaced(const Scene& scene, const std::string& from,
                                            const std::string& to) {
    const auto named = [](const std::vector<Material>& materials, const std::string& name) {
        return std::find_if(materials.begin(), materials.end(),
                            [&](const Material& m) { return m.name == name; });
    };
    const auto old = named(scene.materials, from);
    std::vector<Material> known = scene.materials;
    for (const LibraryMaterial& entry : material_library()) known.push_back(entry.material);
    const auto wanted = named(known, to);
    if (old == scene.materials.end() || wanted == known.end()) return std::nullopt;
    std::vector<std::uint32_t> triangles;
    std::uint32_t t = 0;
    for (const Object& object : scene.objects) {
        for (const std::uint32_t material : object.triangle_materials) {
            if (material == static_cast<std::uint32_t>(old - scene.materials.begin()))
                triangles.push_back(t);
            ++t;
        }
    }
    return with_material(scene, triangles, *wanted);
}

}  // namespace aula
