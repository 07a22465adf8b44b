#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "engine/patches/patch_index.h"
#include "engine/rays/ray_scene.h"
#include "engine/rays/scene_planes.h"

namespace aula {

/// Divides patches by panels. A panel is a plane face as large as part of a patch: of a moving
/// object, such as one side of a door leaf or of a screen, or a static partition of one face within
/// cells, at which the grid is not cut. In the cells that panels cross, a patch has one row of
/// energies for each combination of the panels' sides instead of a single one, so that the energy
/// that falls on one side of a shut door does not leave on the other side. Such a row holds the
/// energy per area times reference_m2().
///
/// The rows are those of the scene's present state: each movement releases the rows of the patches
/// that moving objects divide, and adds new ones. Patches that only static panels divide keep their
/// rows. [propagation thread; const functions may run on several threads]
class PatchSides {
 public:
    static constexpr std::uint32_t kNone = PatchIndex::kNone;

    /// Samples of a full cell from which the areas of sides are found. A choice: the standard error
    /// of a quarter of the area is a tenth of it.
    static constexpr int kSideSamples = 256;

    /// Panels have at least a quarter of the area of a patch. Rows have numbers of `index`.
    PatchSides(const RayScene& scene, PatchIndex& index, float patch_size_m);

    /// Adds panels: the planes of static triangles that have sound on both sides. Triangles of
    /// existing panels are ignored. True if there are new ones.
    bool add_partitions(const std::vector<std::uint32_t>& triangles);

    /// Number of panels: those of moving objects, then static ones.
    std::size_t panel_count() const { return panels_.size(); }

    /// The panel of a triangle, or kNone.
    std::uint32_t panel_of(std::uint32_t triangle) const {
        return triangle < panel_of_.size() ? panel_of_[triangle] : kNone;
    }

    /// Begins an update after a movement of the scene: no panel crosses a cell.
    void begin_move();

    /// Records that a panel crosses the cell of a patch. Of more than six in a cell, the largest
    /// divide it. True if the patch was not divided before: add_static() must follow.
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

    /// Ends an update: finds the rows and their areas.
    void end_move();

    /// Removes the sides of a patch and releases their rows.
    void remove(std::uint32_t patch);

    bool divided(std::uint32_t patch) const {
        return patch < divisions_.size() && divisions_[patch];
    }

    /// Number of rows for the energy of a patch: its own, or those of its sides.
    std::size_t row_count(std::uint32_t patch) const {
        return divided(patch) ? divisions_[patch]->rows.size() : 1;
    }

    /// The only row for the energy that leaves a point of a divided patch, and the factor of the
    /// energy. kNone: the point is in a part whose area is too small to be known.
    struct Target {
        std::uint32_t row = kNone;
        float factor = 1;
    };
    Target target(std::uint32_t patch, const Vec3& point) const;

    /// The area to which the energies of rows refer.
    float reference_m2() const { return reference_m2_; }

    /// The area of a patch's row; 0 for a row that is not one of its sides.
    float area_m2(std::uint32_t patch, std::uint32_t row) const;

 private:
    struct Panel {
        std::uint32_t reference = 0;  ///< its largest triangle
        float area_m2 = 0;
        Vec3 normal{0};  ///< of the plane at the last update
        float offset_m = 0;
    };

    /// Sets of sides are bit masks; bit k is the side of the division's panel k to which its normal
    /// points.
    struct Row {
        std::uint32_t sides = 0;
        std::uint32_t number = 0;
        float area_m2 = 0;
    };

    struct Division {
        struct Sample {
            Vec3 point;
            float area_m2 = 0;
        };
        std::vector<std::uint32_t> panels;  ///< that cross the cell, sorted
        std::vector<Row> rows;              ///< empty: to be found
        std::vector<Sample> static_samples;
        std::vector<Sample> moving_samples;
    };

    void add_panels(bool moving, const std::vector<char>& wanted_planes, const ScenePlanes& planes);
    bool has_moving(const Division& division) const;
    std::uint32_t sides_of(const Division& division, const Vec3& point) const;
    void release_rows(Division& division);
    void find_rows(std::uint32_t patch, Division& division);

    const RayScene& scene_;
    PatchIndex& index_;
    float reference_m2_;
    std::vector<std::uint32_t> panel_of_;  ///< [triangle]; empty without panels
    std::vector<Panel> panels_;
    std::size_t moving_panels_ = 0;                     ///< the first ones
    std::vector<std::unique_ptr<Division>> divisions_;  ///< [patch]
};

}  // namespace aula
