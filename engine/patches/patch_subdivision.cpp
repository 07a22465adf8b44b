#include "engine/patches/patch_subdivision.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <glm/geometric.hpp>

namespace aula {

namespace {

/// Rows or columns of a triangle at most: a kilometre of millimetres.
constexpr float kMostParts = 1 << 20;

/// ceil(x) as a count of at least 1.
std::uint32_t count_of(float x) {
    return static_cast<std::uint32_t>(std::clamp(std::ceil(x), 1.0F, kMostParts));
}

}  // namespace

PatchSubdivision::PatchSubdivision(const RayScene& scene, float patch_size_m) {
    assert(patch_size_m > 0);
    grids_.reserve(scene.triangle_count());
    for (const RayScene::Triangle& triangle : scene.triangles()) {
        const auto& v = triangle.vertices;
        // The longest altitude is on the shortest edge: opposite[k] faces vertex k.
        const std::array<float, 3> opposite{glm::distance(v[1], v[2]), glm::distance(v[2], v[0]),
                                            glm::distance(v[0], v[1])};
        const auto key = static_cast<std::uint32_t>(
            std::min_element(opposite.begin(), opposite.end()) - opposite.begin());
        const float edge_m = opposite[key];
        const float altitude_m = edge_m > 0 ? 2 * triangle.area_m2() / edge_m : 0;
        grids_.push_back(
            {count_of(altitude_m / patch_size_m), count_of(edge_m / patch_size_m), key});
    }
}

std::uint32_t PatchSubdivision::columns(const Grid& grid, std::uint32_t zeta) {
    // Eq. 3.1: N_xi_zeta = (N_zeta - zeta) / N_zeta * N_xi, rounded up, in integers.
    const std::uint64_t numerator = std::uint64_t{grid.rows - zeta} * grid.columns;
    return static_cast<std::uint32_t>((numerator + grid.rows - 1) / grid.rows);
}

Patch PatchSubdivision::patch(const Hit& hit, bool back) const {
    const Grid& grid = grids_[hit.triangle];
    const std::array<float, 3> gamma{1 - hit.u - hit.v, hit.u, hit.v};
    const float gamma_key = std::max(gamma[grid.key_vertex], 0.0F);
    // With the key vertex at the top, the next vertex in counter-clockwise order is on its left.
    const float gamma_left = std::max(gamma[(grid.key_vertex + 1) % 3], 0.0F);
    const auto zeta = std::min(
        static_cast<std::uint32_t>(gamma_key * static_cast<float>(grid.rows)), grid.rows - 1);
    // Differs from the text's xi = floor(gamma_va N_xi_zeta): in row zeta gamma_va is at most 1 -
    // gamma_vk, so that factor would apply twice. With N_xi all patches are equally wide and the
    // row has exactly the columns of Eq. 3.1.
    const auto xi =
        std::min(static_cast<std::uint32_t>(gamma_left * static_cast<float>(grid.columns)),
                 columns(grid, zeta) - 1);
    return {hit.triangle, zeta, xi, back};
}

}  // namespace aula
