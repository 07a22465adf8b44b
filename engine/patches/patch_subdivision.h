#pragma once

#include <cstdint>
#include <vector>

#include "engine/rays/ray_scene.h"

namespace aula {

/// A surface patch T(zeta, xi) of the barycentric subdivision. The two sides of a triangle are
/// separate patches.
struct Patch {
    std::uint32_t triangle = 0;
    std::uint32_t zeta = 0;  ///< row
    std::uint32_t xi = 0;    ///< column
    bool back = false;       ///< the side opposite the triangle's normal

    friend bool operator==(const Patch&, const Patch&) = default;
};

/// Divides every triangle into a grid of patches of size lambda by barycentric coordinates. Patches
/// are not stored: a triangle stores the numbers of rows and columns and its key vertex.
class PatchSubdivision {
 public:
    struct Grid {
        std::uint32_t rows = 1;     ///< N_zeta
        std::uint32_t columns = 1;  ///< N_xi, of the largest row
        std::uint32_t key_vertex = 0;
    };

    /// `patch_size_m` is lambda, > 0.
    PatchSubdivision(const RayScene& scene, float patch_size_m);

    Patch patch(const Hit& hit, bool back) const;

    /// Number of columns of a row, Eq. 3.1.
    static std::uint32_t columns(const Grid& grid, std::uint32_t zeta);

    const Grid& grid(std::uint32_t triangle) const { return grids_[triangle]; }

 private:
    std::vector<Grid> grids_;
};

}  // namespace aula
