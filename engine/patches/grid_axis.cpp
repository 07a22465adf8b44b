#include "engine/patches/grid_axis.h"

#include <algorithm>
#include <cmath>

namespace aula {

namespace {

/// Least gap between walls, as a share of a cell's width. A choice: the sides of a partition wall
/// of 0.1 m are two cuts of cells up to 1 m, and the table of slots has at most twenty times as
/// many slots as cells.
constexpr float kMinGap = 0.1F;

/// Share of a slot by which it begins early: above a rounding of 10^5 slots, 2^-24 of them.
constexpr float kEarly = 0.01F;

}  // namespace

GridAxis::GridAxis(float length_m, float cell_m, std::vector<Wall> walls)
    : cell_m_(cell_m), length_m_(std::max(0.0F, length_m)) {
    if (!(length_m > 0)) return;
    std::sort(walls.begin(), walls.end(), [](const Wall& a, const Wall& b) {
        return a.area_m2 != b.area_m2 ? a.area_m2 > b.area_m2 : a.at_m < b.at_m;
    });
    std::vector<float> cuts{0, length_m};
    const float max = 2 + length_m / cell_m;  // the ends, and as many walls as cells
    for (const Wall& wall : walls) {
        if (static_cast<float>(cuts.size()) >= max) break;
        const bool apart = std::all_of(cuts.begin(), cuts.end(), [&](float cut) {
            return std::abs(wall.at_m - cut) >= kMinGap * cell_m;
        });
        if (apart) cuts.push_back(wall.at_m);
    }
    std::sort(cuts.begin(), cuts.end());

    // Equal cells between two cuts.
    edges_m_ = {0};
    float narrowest_m = length_m;
    for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
        const float gap_m = cuts[i + 1] - cuts[i];
        const float parts = std::max(1.0F, parts_of(gap_m, cell_m));
        for (float k = 1; k < parts; ++k) edges_m_.push_back(cuts[i] + gap_m * k / parts);
        edges_m_.push_back(cuts[i + 1]);
        narrowest_m = std::min(narrowest_m, gap_m / parts);
    }

    // Half as wide as the narrowest cell, a slot intersects at most two cells. It starts slightly
    // early, because a position near its start may be rounded into it.
    slots_ = std::ceil(2 * length_m / narrowest_m);
    slots_per_m_ = slots_ / length_m;
    first_.clear();
    std::int32_t cell = 0;
    for (float slot = 0; slot <= slots_; ++slot) {
        const float begin_m = (slot - kEarly) / slots_per_m_;
        while (cell + 1 < count() && edges_m_[static_cast<std::size_t>(cell) + 1] <= begin_m) {
            ++cell;
        }
        first_.push_back(cell);
    }
}

}  // namespace aula
