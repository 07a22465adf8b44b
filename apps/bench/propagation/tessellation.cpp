#include "apps/bench/propagation/tessellation.h"

#include <cmath>
#include <utility>
#include <vector>

namespace aula::bench {

namespace {

/// The point at the fraction i / n from a to b, identical to the bit from either end.
Vec3 between(Vec3 a, Vec3 b, std::uint32_t i, std::uint32_t n) {
    const auto order = [](const Vec3& p) { return std::array{p.x, p.y, p.z}; };
    if (order(b) < order(a)) {
        std::swap(a, b);
        i = n - i;
    }
    if (i == 0) return a;
    if (i == n) return b;
    return a + (b - a) * (static_cast<float>(i) / static_cast<float>(n));
}

void divide(Object& object, std::uint32_t n) {
    const std::vector<Vec3> vertices = std::move(object.vertices);
    const auto triangles = std::move(object.triangles);
    const std::vector<std::uint32_t> materials = std::move(object.triangle_materials);
    object.vertices.clear();
    object.triangles.clear();
    object.triangle_materials.clear();
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        const Vec3& a = vertices[triangles[t][0]];
        const Vec3& b = vertices[triangles[t][1]];
        const Vec3& c = vertices[triangles[t][2]];
        // Row r runs from edge ab to edge ac and has r + 1 corners.
        auto row = static_cast<std::uint32_t>(object.vertices.size());
        object.vertices.push_back(a);
        for (std::uint32_t r = 1; r <= n; ++r) {
            const std::uint32_t before = row;
            row += r;
            const Vec3 left = between(a, b, r, n);
            const Vec3 right = between(a, c, r, n);
            for (std::uint32_t k = 0; k <= r; ++k) {
                object.vertices.push_back(between(left, right, k, r));
            }
            for (std::uint32_t k = 0; k < r; ++k) {
                object.triangles.push_back({before + k, row + k, row + k + 1});
                if (k + 1 < r)
                    object.triangles.push_back({before + k, row + k + 1, before + k + 1});
            }
        }
        object.triangle_materials.resize(object.triangles.size(), materials[t]);
    }
}

}  // namespace

void tessellate(Scene& scene, std::size_t triangles) {
    std::size_t given = 0;
    for (const Object& object : scene.objects) given += object.triangles.size();
    if (given == 0) return;
    const auto n = static_cast<std::uint32_t>(
        std::ceil(std::sqrt(static_cast<double>(triangles) / static_cast<double>(given))));
    if (n < 2) return;
    for (Object& object : scene.objects) divide(object, n);
}

}  // namespace aula::bench
