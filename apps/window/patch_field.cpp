#include "apps/window/patch_field.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <limits>

#include "apps/window/curves.h"

namespace aula {

void PatchField::cover(const Vec3& low, const Vec3& high, float patch_size_m) {
    constexpr float kMostCells = 1.5e6F;
    cell_m_ = std::max(patch_size_m, 0.01F);
    for (;; cell_m_ *= 2) {
        size_ = glm::ivec3(glm::ceil((high - low) / cell_m_)) + 1;
        const glm::vec3 cells(size_);
        if (6 * cells.x * cells.y * cells.z <= kMostCells) break;
    }
    origin_ = low;
    const auto count = 6 * static_cast<std::size_t>(size_.x) * static_cast<std::size_t>(size_.y) *
                       static_cast<std::size_t>(size_.z);
    energy_.assign(count, 0);
    level_.assign(count, 0);
    texels_.assign(count, {});
    top_db_ = kNothing_db;
}

std::size_t PatchField::index(const PatchGrid::Cell& cell) const {
    const Vec3& d = cell.direction;
    const int axis = d.x != 0 ? 0 : d.y != 0 ? 1 : 2;
    const int direction = 2 * axis + (d[axis] < 0 ? 1 : 0);
    const glm::ivec3 place = glm::clamp(glm::ivec3(glm::floor((cell.middle - origin_) / cell_m_)),
                                        glm::ivec3(0), size_ - 1);
    return static_cast<std::size_t>(
        ((direction * size_.z + place.z) * size_.y + place.y) * size_.x + place.x);
}

void PatchField::follow(const std::vector<PatchEnergy>& patches, std::size_t band, double dt_s) {
    constexpr double kFollow_s = 0.15;
    constexpr float kTopFalls_db_s = 6;
    std::fill(energy_.begin(), energy_.end(), 0.0F);
    float loudest_db = kNothing_db;
    for (const PatchEnergy& patch : patches) {
        const auto energy = static_cast<float>(band_energy(patch.energy, band));
        const std::size_t at = index(patch.cell);
        energy_[at] = std::max(energy_[at], energy);
        texels_[at].there = 255;
        loudest_db = std::max(loudest_db, energy_db(static_cast<double>(energy)));
    }
    if (loudest_db > kNothing_db)
        top_db_ = std::max(loudest_db, top_db_ - kTopFalls_db_s * static_cast<float>(dt_s));
    const auto weight = static_cast<float>(1 - std::exp(-dt_s / kFollow_s));
    for (std::size_t i = 0; i < energy_.size(); ++i) {
        if (texels_[i].there == 0) continue;
        const float wanted = 1 + (energy_db(static_cast<double>(energy_[i])) - top_db_) / kRange_db;
        level_[i] += weight * (std::clamp(wanted, 0.0F, 1.0F) - level_[i]);
        texels_[i].level = static_cast<std::uint8_t>(std::lround(255 * level_[i]));
    }
}

}  // namespace aula
