#include "engine/patches/patch_sides.h"

#include <algorithm>
#include <iterator>
#include <map>
#include <span>
#include <utility>

namespace aula {

namespace {

constexpr float kMinPanel = 0.25F;  // least area of a panel, as a share of a full patch

/// Least area of a row, as a share of a full patch, so that energies per area stay in range. A
/// smaller row loses part of its energy.
constexpr float kMinArea = 1.0F / 256;

}  // namespace

PatchSides::PatchSides(const RayScene& scene, float patch_size_m)
    : scene_(scene), reference_m2_(patch_size_m * patch_size_m) {
    const auto& all = scene.triangles();
    const bool moves = std::any_of(all.begin(), all.end(), [&](const RayScene::Triangle& triangle) {
        return scene.moves(triangle);
    });
    if (!moves) return;
    const ScenePlanes planes(scene_);
    add_panels(true, std::vector<char>(planes.count(), 1), planes);
    moving_panels_ = panels_.size();
}

bool PatchSides::add_partitions(const std::vector<std::uint32_t>& triangles) {
    std::vector<std::uint32_t> added;
    std::copy_if(triangles.begin(), triangles.end(), std::back_inserter(added),
                 [&](std::uint32_t t) { return panel_of(t) == kNone; });
    if (added.empty()) return false;
    const ScenePlanes planes(scene_);
    std::vector<char> wanted(planes.count(), 0);
    for (const std::uint32_t t : added) {
        if (planes.of_triangle(t) != ScenePlanes::kNoPlane) wanted[planes.of_triangle(t)] = 1;
    }
    const std::size_t before = panels_.size();
    add_panels(false, wanted, planes);
    return panels_.size() > before;
}

/// Adds the panels of moving objects, or static ones, in some planes.
void PatchSides::add_panels(bool moving, const std::vector<char>& wanted_planes,
                            const ScenePlanes& planes) {
    constexpr std::uint32_t kAllObjects = ~0U;
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::vector<std::uint32_t>> faces;
    for (std::uint32_t t = 0; t < scene_.triangle_count(); ++t) {
        const RayScene::Triangle& triangle = scene_.triangle(t);
        const std::uint32_t plane = planes.of_triangle(t);
        if (scene_.moves(triangle) != moving || plane == ScenePlanes::kNoPlane ||
            !wanted_planes[plane] || panel_of(t) != kNone)
            continue;
        faces[{moving ? triangle.object : kAllObjects, plane}].push_back(t);
    }
    std::vector<std::pair<Panel, std::span<const std::uint32_t>>> found;
    for (const auto& [plane, triangles] : faces) {
        Panel panel;
        float largest_m2 = 0;
        for (const std::uint32_t t : triangles) {
            const float area_m2 = scene_.triangle(t).area_m2();
            panel.area_m2 += area_m2;
            if (area_m2 <= largest_m2) continue;
            largest_m2 = area_m2;
            panel.reference = t;
        }
        if (panel.area_m2 >= kMinPanel * reference_m2_) found.emplace_back(panel, triangles);
    }
    // If too many panels cross a cell, the largest are kept.
    std::stable_sort(found.begin(), found.end(), [](const auto& a, const auto& b) {
        return a.first.area_m2 > b.first.area_m2;
    });
    if (!found.empty()) panel_of_.resize(scene_.triangle_count(), kNone);
    for (const auto& [panel, triangles] : found) {
        for (const std::uint32_t t : triangles) {
            panel_of_[t] = static_cast<std::uint32_t>(panels_.size());
        }
        panels_.push_back(panel);
    }
}

/// True if the areas of a division's rows may change in each move.
bool PatchSides::has_moving(const Division& division) const {
    if (!division.moving_samples.empty()) return true;
    for (std::size_t k = 0; k < kMaxPanels; ++k) {
        if ((division.crossing >> k & 1U) != 0 && division.slots[k].panel < moving_panels_)
            return true;
    }
    return false;
}

void PatchSides::begin_move(std::uint64_t keep, const std::function<void(std::uint32_t)>& release) {
    ++moves_;
    for (Panel& panel : panels_) {
        const RayScene::Triangle& triangle = scene_.triangle(panel.reference);
        panel.normal = triangle.normal;
        panel.offset_m = glm::dot(triangle.normal, triangle.vertices[0]);
    }
    for (auto& division : divisions_) {
        if (!division) continue;
        // Rows were added at the last crossing of their panels or earlier. They are therefore
        // removed before the slots of these panels.
        std::erase_if(division->rows, [&](const Row& row) {
            if (moves_ - row.added <= keep) return false;
            release(row.number);
            return true;
        });
        bool used = false;
        for (Division::Slot& slot : division->slots) {
            if (slot.panel == kNone) continue;
            if (moves_ - slot.crossed > keep) {
                slot = {};
                continue;
            }
            used = true;
            slot.normal = panels_[slot.panel].normal;
            slot.offset_m = panels_[slot.panel].offset_m;
        }
        division->crossing = 0;
        division->moving_samples.clear();
        if (!used) division.reset();
    }
}

bool PatchSides::cross(std::uint32_t patch, std::uint32_t panel) {
    if (patch >= divisions_.size()) divisions_.resize(patch + 1);
    const bool added = !divisions_[patch];
    if (added) divisions_[patch] = std::make_unique<Division>();
    auto& slots = divisions_[patch]->slots;
    const auto with = [&](std::uint32_t wanted) {
        return std::find_if(slots.begin(), slots.end(),
                            [&](const Division::Slot& slot) { return slot.panel == wanted; });
    };
    auto slot = with(panel);
    if (slot == slots.end()) slot = with(kNone);
    if (slot != slots.end()) {
        *slot = {panel, moves_, panels_[panel].normal, panels_[panel].offset_m};
        divisions_[patch]->crossing |= 1U << (slot - slots.begin());
    }
    return added;
}

std::vector<std::uint32_t> PatchSides::clear_static() {
    std::vector<std::uint32_t> patches;
    for (std::uint32_t patch = 0; patch < divisions_.size(); ++patch) {
        if (!divisions_[patch]) continue;
        divisions_[patch]->static_samples.clear();
        divisions_[patch]->counted = 0;
        patches.push_back(patch);
    }
    return patches;
}

void PatchSides::add_static(std::uint32_t patch, const Vec3& point, float area_m2) {
    divisions_[patch]->static_samples.push_back({point, area_m2});
    divisions_[patch]->counted = 0;
}

void PatchSides::add_moving(std::uint32_t patch, const Vec3& point, float area_m2) {
    if (divided(patch)) divisions_[patch]->moving_samples.push_back({point, area_m2});
}

void PatchSides::end_move(const std::function<std::uint32_t(std::uint32_t)>& new_row) {
    for (std::uint32_t patch = 0; patch < divisions_.size(); ++patch) {
        if (!divisions_[patch]) continue;
        Division& division = *divisions_[patch];
        const bool moving = has_moving(division);
        if (!moving && division.crossing != 0 && division.counted == division.crossing) {
            for (Row& row : division.rows) {
                if (row.area_m2 > 0) row.added = moves_;
            }
            continue;
        }
        division.counted = moving ? 0 : division.crossing;
        for (Row& row : division.rows) row.area_m2 = 0;
        if (division.crossing == 0) continue;
        std::array<float, 1U << kMaxPanels> areas_m2{};
        for (const auto* samples : {&division.static_samples, &division.moving_samples}) {
            for (const Division::Sample& sample : *samples) {
                areas_m2[division.sides_of(sample.point) & division.crossing] += sample.area_m2;
            }
        }
        for (std::uint32_t sides = 0; sides < areas_m2.size(); ++sides) {
            if (!(areas_m2[sides] > 0)) continue;
            auto row = std::find_if(division.rows.begin(), division.rows.end(), [&](const Row& r) {
                return r.panels == division.crossing && r.sides == sides;
            });
            if (row == division.rows.end()) {
                division.rows.push_back({division.crossing, sides, new_row(patch)});
                row = std::prev(division.rows.end());
            }
            row->area_m2 = areas_m2[sides];
            row->added = moves_;
        }
    }
}

void PatchSides::remove(std::uint32_t patch, const std::function<void(std::uint32_t)>& release) {
    if (!divided(patch)) return;
    for (const Row& row : divisions_[patch]->rows) release(row.number);
    divisions_[patch].reset();
}

PatchSides::Target PatchSides::target(std::uint32_t patch, const Vec3& point) const {
    if (!divided(patch) || divisions_[patch]->crossing == 0) return {patch, 1};
    const Division& division = *divisions_[patch];
    const std::uint32_t sides = division.sides_of(point) & division.crossing;
    for (const Row& row : division.rows) {
        if (row.panels == division.crossing && row.sides == sides && row.area_m2 > 0) {
            return {row.number, reference_m2_ / std::max(row.area_m2, kMinArea * reference_m2_)};
        }
    }
    return {};
}

float PatchSides::area_m2(std::uint32_t patch, std::uint32_t number) const {
    if (!divided(patch)) return 0;
    for (const Row& row : divisions_[patch]->rows) {
        if (row.number == number) return row.area_m2;
    }
    return 0;
}

}  // namespace aula
