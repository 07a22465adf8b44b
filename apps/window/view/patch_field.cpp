#include "apps/window/view/patch_field.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <limits>

#include "apps/window/view/curves.h"

namespace aula {

void PatchField::cover(const Vec3& low, const Vec3& high, float patch_size_m) {
    constexpr float kMaxCells = 1.5e6F;
    cell_m_ = std::max(patch_size_m / 2, 0.01F);
    for (;; cell_m_ *= 2) {
        size_ = glm::ivec3(glm::ceil((high - low) / cell_m_)) + 1;
        const glm::vec3 cells(size_);
        if (6 * cells.x * cells.y * cells.z <= kMaxCells) break;
    }
    origin_ = low;
    const auto count = 6 * static_cast<std::size_t>(size_.x) * static_cast<std::size_t>(size_.y) *
                       static_cast<std::size_t>(size_.z);
    energy_.assign(count, 0);
    level_.assign(count, 0);
    texels_.assign(count, {});
    occupied_.clear();
    top_db_ = kSilence_db;
}

/// Calls `visit(index)` for the texel at the cell's centre and for those whose centres are in the
/// cell, all of the cell's direction.
template <typename Visit>
void PatchField::for_each_texel(const PatchCell& cell, const Visit& visit) const {
    const Vec3& d = cell.direction;
    const int axis = d.x != 0 ? 0 : d.y != 0 ? 1 : 2;
    const int direction = 2 * axis + (d[axis] < 0 ? 1 : 0);
    const auto texel = [&](const Vec3& position) {
        return glm::clamp(glm::ivec3(glm::floor((position - origin_) / cell_m_)), glm::ivec3(0),
                          size_ - 1);
    };
    const glm::ivec3 middle = texel((cell.low + cell.high) * 0.5F);
    // The first texel whose centre is at or above the low corner, and the last one whose centre is
    // below the high corner.
    const glm::ivec3 first = glm::min(middle, texel(cell.low + 0.4999F * cell_m_));
    const glm::ivec3 last = glm::max(middle, texel(cell.high - 0.5001F * cell_m_));
    for (int z = first.z; z <= last.z; ++z)
        for (int y = first.y; y <= last.y; ++y)
            for (int x = first.x; x <= last.x; ++x)
                visit(static_cast<std::size_t>(((direction * size_.z + z) * size_.y + y) * size_.x +
                                               x));
}

void PatchField::update(const std::vector<PatchEnergy>& patches, std::size_t band, double dt_s) {
    constexpr double kSmoothing_s = 0.15;
    constexpr float kTopFalls_db_s = 6;
    for (const std::size_t i : occupied_) energy_[i] = 0;
    float loudest_db = kSilence_db;
    for (const PatchEnergy& patch : patches) {
        const auto energy = static_cast<float>(band_energy(patch.energy, band));
        for_each_texel(patch.cell, [&](std::size_t at) {
            energy_[at] = std::max(energy_[at], energy);
            if (texels_[at].occupied != 0) return;
            texels_[at].occupied = 255;
            occupied_.push_back(at);
        });
        loudest_db = std::max(loudest_db, energy_db(static_cast<double>(energy)));
    }
    if (loudest_db > kSilence_db)
        top_db_ = std::max(loudest_db, top_db_ - kTopFalls_db_s * static_cast<float>(dt_s));
    const auto weight = static_cast<float>(1 - std::exp(-dt_s / kSmoothing_s));
    for (const std::size_t i : occupied_) {
        const float wanted = 1 + (energy_db(static_cast<double>(energy_[i])) - top_db_) / kRange_db;
        level_[i] += weight * (std::clamp(wanted, 0.0F, 1.0F) - level_[i]);
        texels_[i].level = static_cast<std::uint8_t>(std::lround(255 * level_[i]));
    }
}

}  // namespace aula
