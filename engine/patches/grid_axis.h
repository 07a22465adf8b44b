#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "engine/base/tolerances.h"

namespace aula {

/// Cells along one axis, at most as wide as requested and cut at walls, so that no cell extends
/// through a wall. Beyond the ends all cells have the requested width. [propagation thread]
class GridAxis {
 public:
    /// A wall: its position on the axis and its area.
    struct Wall {
        float at_m = 0;
        double area_m2 = 0;
    };

    GridAxis() = default;

    /// Cells from 0 to `length_m`. If walls are closer to each other than a tenth of a cell, only
    /// the largest cuts. The largest walls are considered first, until the number of cells is twice
    /// that without walls.
    GridAxis(float length_m, float cell_m, std::vector<Wall> walls);

    /// The cell of a position, negative before 0. Invalid positions (NaN, or more than 2^24 cells
    /// away) count as 0. The function has no branches, so that compilers can vectorise it.
    std::int32_t cell(float given_m) const {
        const float at_m = std::abs(given_m) < kFurthest_cells * cell_m_ ? given_m : 0;
        const auto slot = static_cast<std::int32_t>(std::clamp(at_m * slots_per_m_, 0.0F, slots_));
        const std::int32_t first = first_[static_cast<std::size_t>(slot)];
        const std::int32_t inside =
            first + (at_m >= edges_m_[static_cast<std::size_t>(first) + 1] ? 1 : 0);
        const std::int32_t before = static_cast<std::int32_t>(at_m / cell_m_) - 1;
        const std::int32_t beyond =
            count() + static_cast<std::int32_t>((at_m - length_m_) / cell_m_);
        return at_m < 0 ? before : at_m >= length_m_ ? beyond : inside;
    }

    /// The number of cells of about `cell_m` at most in a gap: a gap of whole cells remains so
    /// under rounding.
    static float parts_of(float gap_m, float cell_m) {
        return std::ceil(gap_m / (cell_m * (1 + kWider)));
    }

    /// The start of a cell.
    float begin_m(std::int32_t cell) const {
        if (cell < 0) return static_cast<float>(cell) * cell_m_;
        if (cell <= count()) return edges_m_[static_cast<std::size_t>(cell)];
        return edges_m_.back() + static_cast<float>(cell - count()) * cell_m_;
    }

 private:
    /// From here on single precision has no places within a cell, and an index may overflow.
    static constexpr float kFurthest_cells = 1 << std::numeric_limits<float>::digits;

    /// Share by which cells may be wider than requested. A choice, above the rounding of positions
    /// 500 cells away.
    static constexpr float kWider = 1e-3F;
    static_assert(kWider > 500 * tolerances::kRounding);

    std::int32_t count() const { return static_cast<std::int32_t>(edges_m_.size()) - 1; }

    float cell_m_ = 1;
    float length_m_ = 0;
    float slots_ = 0;  ///< number of equal slots, each narrower than any cell
    float slots_per_m_ = 0;
    std::vector<float> edges_m_{0, 0};
    std::vector<std::int32_t> first_{0};  ///< [slot] the cell that contains the start of the slot
};

}  // namespace aula
