#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "engine/estimate/frame_view.h"

namespace aula {

/// What the patches radiate, as six boxes of cells, one for each direction that a surface can face,
/// for a shader to look up by place and direction. Levels follow the energies with a short delay,
/// so that what is gone fades. Cells are joined where there would be too many.
class PatchField {
 public:
    /// A cell: level 0..255, and 255 where there is a patch.
    struct Texel {
        std::uint8_t level = 0;
        std::uint8_t there = 0;
    };

    /// Covers a room with patches of about a size, by texels of half of it.
    void cover(const Vec3& low, const Vec3& high, float patch_size_m);

    /// Follows energies of a band, or of all (kBandCount), for `dt_s`. The loudest is at full
    /// level, what is kRange_db lower at none; the loudest falls slowly when it gets quieter.
    void follow(const std::vector<PatchEnergy>& patches, std::size_t band, double dt_s);

    /// [direction][z][y][x], directions +x -x +y -y +z -z.
    const std::vector<Texel>& texels() const { return texels_; }
    glm::ivec3 size() const { return size_; }
    Vec3 origin() const { return origin_; }
    float cell_m() const { return cell_m_; }
    float top_db() const { return top_db_; }
    static constexpr float kRange_db = 30;

 private:
    template <typename Visit>
    void for_each_texel(const PatchGrid::Cell& cell, const Visit& visit) const;

    glm::ivec3 size_{0};
    Vec3 origin_{0};
    float cell_m_ = 0.5F;
    float top_db_ = -200;
    std::vector<float> energy_;  ///< [texel] sum of the newest patches
    std::vector<float> level_;   ///< [texel] as shown, 0..1
    std::vector<Texel> texels_;
    std::vector<std::size_t> occupied_;  ///< texels where there is a patch
};

}  // namespace aula
