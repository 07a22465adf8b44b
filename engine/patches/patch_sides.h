#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <glm/geometric.hpp>
#include <memory>
#include <vector>

#include "engine/rays/ray_scene.h"
#include "engine/rays/scene_planes.h"

namespace aula {

/// Divides patches by panels. A panel is a plane face as large as part of a patch: of a moving
/// object, such as one side of a door leaf or of a screen, or a static partition of one face within
/// cells, at which the grid is not cut. In the cells that panels cross, a patch has one row of
/// energies for each combination of the panels' sides, so that the energy that falls on one side of
/// a shut door does not leave on the other side.
///
/// Such a row holds the energy per area times reference_m2(): it remains valid while a panel moves
/// and the areas beside it change. The panels that cross a cell also change with time. Energy is
/// added to the row of all panels that cross it now; a point receives the sum of all rows whose
/// sides do not contradict its own, including the undivided row of the patch. Each frame's energy
/// is in exactly one of them. After a panel has left, its sides are evaluated until its rows hold
/// no energy. [propagation thread; const functions may run on several threads]
class PatchSides {
 public:
    static constexpr std::uint32_t kNone = ~0U;

    /// Panels have at least a quarter of the area of a patch.
    PatchSides(const RayScene& scene, float patch_size_m);

    /// Adds panels: the planes of static triangles that have sound on both sides. Triangles of
    /// existing panels are ignored. True if there are new ones.
    bool add_partitions(const std::vector<std::uint32_t>& triangles);

    /// Number of panels: those of moving objects, then static ones, the largest of each first.
    std::size_t panel_count() const { return panels_.size(); }

    /// The panel of a triangle, or kNone.
    std::uint32_t panel_of(std::uint32_t triangle) const {
        return triangle < panel_of_.size() ? panel_of_[triangle] : kNone;
    }

    /// Begins an update after a movement of the scene. Rows that received nothing in the last
    /// `keep` moves are released by `release(row)`.
    void begin_move(std::uint64_t keep, const std::function<void(std::uint32_t)>& release);

    /// Records that a panel crosses the cell of a patch; call for large panels first. True if the
    /// patch was not divided before: add_static() must follow.
    bool cross(std::uint32_t patch, std::uint32_t panel);

    /// Removes the static surfaces of all divided patches, which it returns: add_static() must
    /// follow, then end_move().
    std::vector<std::uint32_t> clear_static();

    /// Adds a part of a divided patch's static surface; `area_m2` is weighted by its irradiance
    /// relative to the patch's mean.
    void add_static(std::uint32_t patch, const Vec3& point, float area_m2);

    /// Adds a part of a patch's moving surface at its present position. Undivided patches ignore
    /// it.
    void add_moving(std::uint32_t patch, const Vec3& point, float area_m2);

    /// Ends an update: `new_row(patch)` returns the number of a new row of a patch.
    void end_move(const std::function<std::uint32_t(std::uint32_t)>& new_row);

    /// Removes a patch and releases its rows.
    void remove(std::uint32_t patch, const std::function<void(std::uint32_t)>& release);

    bool divided(std::uint32_t patch) const {
        return patch < divisions_.size() && divisions_[patch];
    }

    /// Number of rows that can hold energy of a patch: its own, or those of its sides.
    std::size_t row_count(std::uint32_t patch) const {
        return divided(patch) ? divisions_[patch]->rows.size() : 1;
    }

    /// The row for the energy that leaves a point of a patch, and the factor of the energy. kNone:
    /// the point is in a part whose area is too small to be known.
    struct Target {
        std::uint32_t row = kNone;
        float factor = 1;
    };
    Target target(std::uint32_t patch, const Vec3& point) const;

    /// Calls `visit(row)` for every row of a divided patch that reaches a point, except the
    /// undivided row.
    template <typename Visit>
    void for_each_row(std::uint32_t patch, const Vec3& point, const Visit& visit) const {
        if (!divided(patch)) return;
        const Division& division = *divisions_[patch];
        const std::uint32_t sides = division.sides_of(point);
        for (const Row& row : division.rows) {
            if (((row.sides ^ sides) & row.panels) == 0) visit(row.number);
        }
    }

    /// The area to which the energies of rows refer.
    float reference_m2() const { return reference_m2_; }

    /// The present area of a patch's row; 0 for a row that receives no energy now.
    float area_m2(std::uint32_t patch, std::uint32_t row) const;

 private:
    /// Largest number of panels in a cell. Existing panels stay; if too many are added in one move,
    /// the largest are taken.
    static constexpr std::size_t kMaxPanels = 6;

    struct Panel {
        std::uint32_t reference = 0;  ///< its largest triangle
        float area_m2 = 0;
        Vec3 normal{0};  ///< of the plane at the last update
        float offset_m = 0;
    };

    /// Sets of panels are bit masks; bit k is panel k of the division.
    struct Row {
        std::uint32_t panels = 0;  ///< panels that divided the patch
        std::uint32_t sides = 0;   ///< of these panels, those on whose normal's side the row is
        std::uint32_t number = 0;
        float area_m2 = 0;
        std::uint64_t added = 0;  ///< the last move in which energy was added
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
        std::array<Slot, kMaxPanels> slots;
        std::uint32_t crossing = 0;  ///< panels that cross the cell now
        std::vector<Row> rows;
        std::vector<Sample> static_samples;
        std::vector<Sample> moving_samples;
        std::uint32_t counted = 0;  ///< static panels by which the rows' areas were found; 0: anew

        std::uint32_t sides_of(const Vec3& point) const {
            std::uint32_t sides = 0;
            for (std::size_t k = 0; k < kMaxPanels; ++k) {
                if (glm::dot(slots[k].normal, point) > slots[k].offset_m) sides |= 1U << k;
            }
            return sides;
        }
    };

    void add_panels(bool moving, const std::vector<char>& wanted_planes, const ScenePlanes& planes);
    bool has_moving(const Division& division) const;

    const RayScene& scene_;
    float reference_m2_;
    std::vector<std::uint32_t> panel_of_;  ///< [triangle]; empty without panels
    std::vector<Panel> panels_;
    std::size_t moving_panels_ = 0;                     ///< the first ones
    std::vector<std::unique_ptr<Division>> divisions_;  ///< [patch]
    std::uint64_t moves_ = 0;
};

}  // namespace aula
