#include "engine/patches/patch_sides.h"

#include <algorithm>
#include <array>
#include <glm/geometric.hpp>
#include <iterator>
#include <map>
#include <utility>

namespace aula {

namespace {

/// Least area of a panel, as a share of a full patch. A choice: sound passes beside a smaller face
/// within its cell.
constexpr float kMinPanel = 0.25F;

/// Least area of a row, as a share of a full patch: that of one sample of a side, whose area is not
/// known better. A smaller row loses part of its energy.
constexpr float kMinArea = 1.0F / PatchSides::kSideSamples;

/// Panels that divide a cell at most. A choice: six make up to 64 sides.
constexpr std::size_t kMaxPanels = 6;

}  // namespace

PatchSides::PatchSides(const RayScene& scene, PatchIndex& index, float patch_size_m)
    : scene_(scene), index_(index), reference_m2_(patch_size_m * patch_size_m) {
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
    // In place of an object: static panels may consist of several.
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
        if (panel.area_m2 < kMinPanel * reference_m2_) continue;
        panel_of_.resize(scene_.triangle_count(), kNone);
        for (const std::uint32_t t : triangles)
            panel_of_[t] = static_cast<std::uint32_t>(panels_.size());
        panels_.push_back(panel);
    }
}

/// True if a move may change the areas of a division's rows.
bool PatchSides::has_moving(const Division& division) const {
    return !division.moving_samples.empty() ||
           std::any_of(division.panels.begin(), division.panels.end(),
                       [&](std::uint32_t panel) { return panel < moving_panels_; });
}

std::uint32_t PatchSides::sides_of(const Division& division, const Vec3& point) const {
    std::uint32_t sides = 0;
    for (std::size_t k = 0; k < division.panels.size(); ++k) {
        const Panel& panel = panels_[division.panels[k]];
        if (glm::dot(panel.normal, point) > panel.offset_m) sides |= 1U << k;
    }
    return sides;
}

void PatchSides::release_rows(Division& division) {
    for (const Row& row : division.rows) index_.release_side(row.number);
    division.rows.clear();
}

void PatchSides::begin_move() {
    for (Panel& panel : panels_) {
        const RayScene::Triangle& triangle = scene_.triangle(panel.reference);
        panel.normal = triangle.normal;
        panel.offset_m = glm::dot(triangle.normal, triangle.vertices[0]);
    }
    for (auto& division : divisions_) {
        if (!division) continue;
        if (has_moving(*division)) release_rows(*division);
        division->panels.clear();
        division->moving_samples.clear();
    }
}

bool PatchSides::cross(std::uint32_t patch, std::uint32_t panel) {
    if (patch >= divisions_.size()) divisions_.resize(patch + 1);
    const bool added = !divisions_[patch];
    if (added) divisions_[patch] = std::make_unique<Division>();
    std::vector<std::uint32_t>& panels = divisions_[patch]->panels;
    if (panels.size() < kMaxPanels) {
        panels.push_back(panel);
        return added;
    }
    const auto smallest = std::min_element(
        panels.begin(), panels.end(),
        [&](std::uint32_t a, std::uint32_t b) { return panels_[a].area_m2 < panels_[b].area_m2; });
    if (panels_[*smallest].area_m2 < panels_[panel].area_m2) *smallest = panel;
    return added;
}

std::vector<std::uint32_t> PatchSides::clear_static() {
    std::vector<std::uint32_t> patches;
    for (std::uint32_t patch = 0; patch < divisions_.size(); ++patch) {
        if (!divisions_[patch]) continue;
        divisions_[patch]->static_samples.clear();
        release_rows(*divisions_[patch]);
        patches.push_back(patch);
    }
    return patches;
}

void PatchSides::add_static(std::uint32_t patch, const Vec3& point, float area_m2) {
    divisions_[patch]->static_samples.push_back({point, area_m2});
}

void PatchSides::add_moving(std::uint32_t patch, const Vec3& point, float area_m2) {
    if (divided(patch)) divisions_[patch]->moving_samples.push_back({point, area_m2});
}

void PatchSides::end_move() {
    for (std::uint32_t patch = 0; patch < divisions_.size(); ++patch) {
        if (!divisions_[patch]) continue;
        Division& division = *divisions_[patch];
        if (division.panels.empty()) {
            remove(patch);
            continue;
        }
        // In an order that is independent of the panels that others have displaced.
        std::sort(division.panels.begin(), division.panels.end());
        if (has_moving(division)) release_rows(division);
        if (division.rows.empty()) find_rows(patch, division);
    }
}

/// Adds the rows of a patch, from the samples of its surface.
void PatchSides::find_rows(std::uint32_t patch, Division& division) {
    std::array<float, 1U << kMaxPanels> areas_m2{};
    for (const auto* samples : {&division.static_samples, &division.moving_samples}) {
        for (const Division::Sample& sample : *samples) {
            areas_m2[sides_of(division, sample.point)] += sample.area_m2;
        }
    }
    for (std::uint32_t sides = 0; sides < areas_m2.size(); ++sides) {
        if (!(areas_m2[sides] > 0)) continue;
        division.rows.push_back({sides, index_.add_side(patch), areas_m2[sides]});
    }
}

void PatchSides::remove(std::uint32_t patch) {
    if (!divided(patch)) return;
    release_rows(*divisions_[patch]);
    divisions_[patch].reset();
}

PatchSides::Target PatchSides::target(std::uint32_t patch, const Vec3& point) const {
    const Division& division = *divisions_[patch];
    const std::uint32_t sides = sides_of(division, point);
    for (const Row& row : division.rows) {
        if (row.sides != sides) continue;
        return {row.number, reference_m2_ / std::max(row.area_m2, kMinArea * reference_m2_)};
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
