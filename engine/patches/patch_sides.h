#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <glm/geometric.hpp>
#include <memory>
#include <vector>

#include "engine/rays/ray_scene.h"

namespace aula {

/// Divides patches by the panels of moving objects. A panel is a plane face as large as a part of a
/// patch, such as a side of a door's leaf or of a screen. In the cells that panels cross, a patch
/// has one row of energies for each combination of the panels' sides, so that the energy that falls
/// on one side of a shut door does not leave on the other side.
///
/// Such a row holds the energy per area times reference_m2(): it stays right while a panel moves
/// and the areas beside it change. The panels that cross a cell change with time, too. Energy is
/// added to the row of all panels that cross it now; a point receives the sum of all rows that its
/// sides do not contradict, the undivided row of the patch included. Each frame's energy is in one
/// of them. A panel that has left is asked for its sides until its rows hold nothing any more.
/// [propagation thread; const functions may run on several threads]
class PatchSides {
 public:
    static constexpr std::uint32_t kNone = ~0U;

    /// Panels have a fourth of the area of a patch or more.
    PatchSides(const RayScene& scene, float patch_size_m);

    /// Panels, the largest ones first.
    std::size_t panel_count() const { return panels_.size(); }

    /// The panel of a triangle, or kNone.
    std::uint32_t panel_of(std::uint32_t triangle) const {
        return triangle < panel_of_.size() ? panel_of_[triangle] : kNone;
    }

    /// Begins an update after the scene has moved. Rows to which nothing was added in the last
    /// `keep` moves are released by `release(row)`.
    void begin_move(std::uint64_t keep, const std::function<void(std::uint32_t)>& release);

    /// A panel crosses the cell of a patch; large panels come first. True if the patch was not
    /// divided before: add_standing() is to follow.
    bool cross(std::uint32_t patch, std::uint32_t panel);

    /// A part of a divided patch's standing surface; `area_m2` is weighted by its irradiance
    /// relative to the patch's mean.
    void add_standing(std::uint32_t patch, const Vec3& point, float area_m2);

    /// A part of a patch's moving surface as it is now. Patches that are not divided ignore it.
    void add_moving(std::uint32_t patch, const Vec3& point, float area_m2);

    /// Ends an update: `new_row(patch)` gives the number of a further row of a patch.
    void end_move(const std::function<std::uint32_t(std::uint32_t)>& new_row);

    /// Forgets a patch and releases its rows.
    void remove(std::uint32_t patch, const std::function<void(std::uint32_t)>& release);

    bool divided(std::uint32_t patch) const {
        return patch < divisions_.size() && divisions_[patch];
    }

    /// The row to which the energy that leaves a point of a patch is added, times `factor`. kNone:
    /// the point is in a part that is too small to be known.
    struct Target {
        std::uint32_t row = kNone;
        float factor = 1;
    };
    Target target(std::uint32_t patch, const Vec3& point) const;

    /// Calls `visit(row)` for every row of a divided patch, beside its undivided one, that reaches
    /// a point.
    template <typename Visit>
    void for_each_row(std::uint32_t patch, const Vec3& point, const Visit& visit) const {
        if (!divided(patch)) return;
        const Division& division = *divisions_[patch];
        const std::uint32_t sides = division.sides_of(point);
        for (const Row& row : division.rows) {
            if (((row.sides ^ sides) & row.panels) == 0) visit(row.number);
        }
    }

    /// The area that the energies of rows refer to.
    float reference_m2() const { return reference_m2_; }

    /// The area of a patch's row now; 0 for a row that nothing is added to now.
    float area_m2(std::uint32_t patch, std::uint32_t row) const;

 private:
    /// Panels of a cell at the same time: the first ones stay, of those that come together the
    /// largest are taken.
    static constexpr std::size_t kMostPanels = 6;

    struct Panel {
        std::uint32_t reference = 0;  ///< its largest triangle
        float area_m2 = 0;
        Vec3 normal{0};  ///< of the plane now
        float offset_m = 0;
    };

    /// A set of panels is a number, bit k for the k-th of the division.
    struct Row {
        std::uint32_t panels = 0;  ///< that divided the patch
        std::uint32_t sides = 0;   ///< of them, those of which it is on the normal's side
        std::uint32_t number = 0;
        float area_m2 = 0;
        std::uint64_t added = 0;  ///< the last move in which anything was added
    };

    struct Division {
        struct Slot {
            std::uint32_t panel = kNone;
            std::uint64_t crossed = 0;  ///< the last move in which the panel crossed the cell
            Vec3 normal{0};
            float offset_m = 0;
        };
        struct Sample {
            Vec3 point;
            float area_m2 = 0;
        };
        std::array<Slot, kMostPanels> slots;
        std::uint32_t crossing = 0;  ///< panels that cross the cell now
        std::vector<Row> rows;
        std::vector<Sample> standing;
        std::vector<Sample> moving;

        std::uint32_t sides_of(const Vec3& point) const {
            std::uint32_t sides = 0;
            for (std::size_t k = 0; k < kMostPanels; ++k) {
                if (glm::dot(slots[k].normal, point) > slots[k].offset_m) sides |= 1U << k;
            }
            return sides;
        }
    };

    void find_panels();

    const RayScene& scene_;
    float reference_m2_;
    std::vector<std::uint32_t> panel_of_;  ///< [triangle]; empty without panels
    std::vector<Panel> panels_;
    std::vector<std::unique_ptr<Division>> divisions_;  ///< [patch]
    std::uint64_t moves_ = 0;
};

}  // namespace aula
