#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <vector>

#include "engine/direct/edge_row.h"
#include "tests/engine/edges/obstacles.h"

namespace aula::test {

/// A thin wall across x from far below to y = `top_m`.
inline Object screen(float x, float top_m) {
    Object object;
    object.vertices = {
        {x, -kFar_m, -kFar_m}, {x, top_m, -kFar_m}, {x, top_m, kFar_m}, {x, -kFar_m, kFar_m}};
    object.triangles = {{0, 1, 2}, {0, 2, 3}};
    object.triangle_materials = {0, 0};
    return object;
}

/// The row over the edges along z at (x, y), if there is one.
inline std::optional<EdgeRow> row_over(const Place& place,
                                       std::initializer_list<std::array<double, 2>> tops,
                                       const Vec3& source, const Vec3& listener) {
    std::vector<std::uint32_t> edges;
    for (const auto& [x, y] : tops) {
        edges.push_back(static_cast<std::uint32_t>(place.edge_at(x, y) - place.edges.all().data()));
    }
    std::sort(edges.begin(), edges.end());
    return EdgeRow::over(place.edges, edges, source, listener);
}

}  // namespace aula::test
