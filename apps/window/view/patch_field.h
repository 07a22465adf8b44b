#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "aula/engine/frame.h"

namespace aula {

/// The energies that the patches radiate, as six 3D textures, one per facing direction of a
/// surface. A shader looks them up by position and direction. Levels are smoothed over time, so
/// that past energies fade. The texels of large rooms are larger, which limits their number.
class PatchField {
 public:
    /// Level 0..255; `occupied` is 255 where a patch lies, else 0.
    struct Texel {
        std::uint8_t level = 0;
        std::uint8_t occupied = 0;
    };

    /// Covers the box from `low` to `high` with texels of half the patch size. Clears all levels.
    void cover(const Vec3& low, const Vec3& high, float patch_size_m);

    /// Moves the levels towards the energies of a band, or of all bands (kBandCount), over `dt_s`.
    /// The largest energy maps to level 255, kRange_db below it to 0. The top of the range falls
    /// slowly.
    void update(const std::vector<PatchEnergy>& patches, std::size_t band, double dt_s);

    /// [direction][z][y][x], directions +x -x +y -y +z -z.
    const std::vector<Texel>& texels() const { return texels_; }
    glm::ivec3 size() const { return size_; }
    Vec3 origin() const { return origin_; }
    float cell_m() const { return cell_m_; }
    float top_db() const { return top_db_; }
    static constexpr float kRange_db = 30;

 private:
    template <typename Visit>
    void for_each_texel(const PatchCell& cell, const Visit& visit) const;

    glm::ivec3 size_{0};
    Vec3 origin_{0};
    float cell_m_ = 0.5F;
    float top_db_ = -200;
    std::vector<float> energy_;  ///< [texel] largest energy of the newest patches
    std::vector<float> level_;   ///< [texel] smoothed, 0..1
    std::vector<Texel> texels_;
    std::vector<std::size_t> occupied_;  ///< indices of texels with a patch
};

}  // namespace aula
