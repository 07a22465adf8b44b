#include "tests/support/rooms.h"

#include <glm/geometric.hpp>
#include <map>
#include <utility>

#include "engine/base/sampling.h"

namespace aula::test {

namespace {

void add_quad(Object& object, std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d,
              std::uint32_t material) {
    object.triangles.push_back({a, b, c});
    object.triangles.push_back({a, c, d});
    object.triangle_materials.insert(object.triangle_materials.end(), 2, material);
}

}  // namespace

Object box(const Vec3& size, std::uint32_t material, const Vec3& corner) {
    Object object;
    for (int i = 0; i < 8; ++i) {
        object.vertices.push_back(corner +
                                  Vec3(i & 1 ? size.x : 0, i & 2 ? size.y : 0, i & 4 ? size.z : 0));
    }
    add_quad(object, 0, 1, 3, 2, material);
    add_quad(object, 4, 6, 7, 5, material);
    add_quad(object, 0, 4, 5, 1, material);
    add_quad(object, 2, 3, 7, 6, material);
    add_quad(object, 0, 2, 6, 4, material);
    add_quad(object, 1, 5, 7, 3, material);
    return object;
}

void set_walls_across_y(Object& box, std::uint32_t material) {
    for (std::size_t t = 0; t < box.triangles.size(); ++t) {
        const auto& corners = box.triangles[t];
        const float at = box.vertices[corners[0]].y;
        if (box.vertices[corners[1]].y == at && box.vertices[corners[2]].y == at)
            box.triangle_materials[t] = material;
    }
}

Object bumpy_box(const Vec3& size, float cell_m, float bump_m) {
    Object object;
    RandomStream random(1);
    for (int side = 0; side < 6; ++side) {
        const int axis = side / 2;
        const int u = (axis + 1) % 3;
        const int v = (axis + 2) % 3;
        const int rows = static_cast<int>(std::lround(size[u] / cell_m));
        const int columns = static_cast<int>(std::lround(size[v] / cell_m));
        const auto first = static_cast<std::uint32_t>(object.vertices.size());
        for (int i = 0; i <= rows; ++i) {
            for (int j = 0; j <= columns; ++j) {
                Vec3 corner(0);
                corner[u] = size[u] * static_cast<float>(i) / static_cast<float>(rows);
                corner[v] = size[v] * static_cast<float>(j) / static_cast<float>(columns);
                corner[axis] = side % 2 == 0 ? 0 : size[axis];
                const bool inner = i > 0 && i < rows && j > 0 && j < columns;
                if (inner) corner[axis] += bump_m * (2 * random.uniform() - 1);
                object.vertices.push_back(corner);
            }
        }
        const auto at = [&](int i, int j) {
            return first + static_cast<std::uint32_t>(i * (columns + 1) + j);
        };
        for (int i = 0; i < rows; ++i) {
            for (int j = 0; j < columns; ++j) {
                add_quad(object, at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1), 0);
            }
        }
    }
    return object;
}

Object quartered(Object object, const std::function<Vec3(const Vec3&, const Vec3&)>& middle) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto between = [&](std::uint32_t a, std::uint32_t b) {
        const auto [entry, added] = middles.try_emplace(
            std::minmax(a, b), static_cast<std::uint32_t>(object.vertices.size()));
        if (added) object.vertices.push_back(middle(object.vertices[a], object.vertices[b]));
        return entry->second;
    };
    std::vector<std::array<std::uint32_t, 3>> finer;
    for (const auto& [a, b, c] : object.triangles) {
        const std::uint32_t ab = between(a, b);
        const std::uint32_t bc = between(b, c);
        const std::uint32_t ca = between(c, a);
        finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
    }
    object.triangles = std::move(finer);
    object.triangle_materials.assign(object.triangles.size(), 0);
    return object;
}

Object icosphere(float radius_m, int subdivisions) {
    Object object;
    const float t = (1 + std::sqrt(5.0F)) / 2;
    for (const Vec3& v : {Vec3(-1, t, 0), Vec3(1, t, 0), Vec3(-1, -t, 0), Vec3(1, -t, 0),
                          Vec3(0, -1, t), Vec3(0, 1, t), Vec3(0, -1, -t), Vec3(0, 1, -t),
                          Vec3(t, 0, -1), Vec3(t, 0, 1), Vec3(-t, 0, -1), Vec3(-t, 0, 1)}) {
        object.vertices.push_back(radius_m * glm::normalize(v));
    }
    object.triangles = {{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                        {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                        {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                        {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
    const auto on_sphere = [&](const Vec3& a, const Vec3& b) {
        return radius_m * glm::normalize(a + b);
    };
    for (int s = 0; s < subdivisions; ++s) object = quartered(std::move(object), on_sphere);
    object.triangle_materials.assign(object.triangles.size(), 0);
    return object;
}

Object square(float half_side_m) {
    Object object;
    const float h = half_side_m;
    object.vertices = {Vec3(-h, -h, 0), Vec3(h, -h, 0), Vec3(h, h, 0), Vec3(-h, h, 0)};
    add_quad(object, 0, 1, 2, 3, 0);
    return object;
}

Object l_shaped_room() {
    Object object;
    for (const float z : {0.0F, 3.0F}) {
        for (const Vec3& v : {Vec3(0, 0, 0), Vec3(6, 0, 0), Vec3(6, 3, 0), Vec3(3, 3, 0),
                              Vec3(3, 6, 0), Vec3(0, 6, 0)}) {
            object.vertices.push_back(v + Vec3(0, 0, z));
        }
    }
    for (std::uint32_t k = 0; k < 6; ++k) {
        add_quad(object, k, (k + 1) % 6, 6 + (k + 1) % 6, 6 + k, 0);
    }
    for (const std::uint32_t z : {0U, 6U}) {
        add_quad(object, z + 0, z + 1, z + 2, z + 3, 0);
        add_quad(object, z + 0, z + 3, z + 4, z + 5, 0);
    }
    return object;
}

double surface_m2(const Object& object) {
    double sum = 0;
    for (const auto& [a, b, c] : object.triangles) {
        sum += double{glm::length(glm::cross(object.vertices[b] - object.vertices[a],
                                             object.vertices[c] - object.vertices[a]))} /
               2;
    }
    return sum;
}

double volume_m3(const Object& object) {
    double sum = 0;
    for (const auto& [a, b, c] : object.triangles) {
        sum += double{glm::dot(object.vertices[a],
                               glm::cross(object.vertices[b], object.vertices[c]))} /
               6;
    }
    return std::abs(sum);
}

Scene grey_room(const Object& object, float absorption, float scattering, const Vec3& source,
                const Vec3& listener) {
    Scene scene;
    scene.objects.push_back(object);
    scene.materials.push_back({"grey", Bands::filled(absorption), Bands::filled(scattering)});
    scene.medium.air_absorption = false;
    Source s;
    s.name = "source";
    s.position = source;
    scene.sources.push_back(s);
    scene.listener.pose.position = listener;
    scene.simulation.direct = false;
    scene.simulation.specular_order = 0;
    scene.simulation.threads = 1;
    return scene;
}

}  // namespace aula::test
