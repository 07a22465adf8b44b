#include "engine/direct/near_edges.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <utility>

#include "engine/direct/limits.h"

namespace aula {

std::vector<std::size_t> NearEdges::begin_frame(const SceneEdges& edges, const glm::dvec3& source,
                                                const glm::dvec3& listener,
                                                std::span<const Bounds> changed,
                                                std::span<const std::uint32_t> followed) {
    const auto has_left = [&](const glm::dvec3& source_before, const glm::dvec3& listener_before,
                              double by_m) {
        return glm::distance(source, source_before) > by_m ||
               glm::distance(listener, listener_before) > by_m;
    };
    if (has_left(source_, listener_, double{limits::kJump_m})) edges_.clear();
    const bool selects = edges_.empty() ||
                         has_left(selected_source_, selected_listener_, limits::kSelectAnew_m) ||
                         (!changed.empty() && frames_ % kTurns == 0);
    source_ = source;
    listener_ = listener;
    has_changed_ = selects;
    if (selects) select(edges);
    std::vector<std::size_t> due;
    for (std::size_t i = 0; i < edges_.size(); ++i) {
        const Edge& edge = edges_[i];
        if (edge.is_new || edge.is_in_use() || (edge.index + frames_) % kTurns == 0 ||
            is_near_change(edges[edge.index], changed) ||
            std::binary_search(followed.begin(), followed.end(), edge.index)) {
            due.push_back(i);
        }
    }
    ++frames_;
    return due;
}

/// Selects the edges of the smallest detours. Known ones keep their results.
void NearEdges::select(const SceneEdges& edges) {
    const double straight_m = glm::distance(source_, listener_);
    // Until the next selection each end may change a detour by twice its movement.
    const double longest_m = limits::kLongestDetour_m + 4 * limits::kSelectAnew_m;
    std::vector<std::pair<double, std::uint32_t>> detours;
    for (std::uint32_t e = 0; e < edges.count(); ++e) {
        const DiffractionEdge& edge = edges[e];
        const WedgePoint s = edge.beside(source_);
        const WedgePoint l = edge.beside(listener_);
        if (!(s.radius_m + l.radius_m > 0)) continue;
        const double along_m = std::clamp(apex_m(s, l), 0.0, edge.length_m);
        const double detour_m = length_over_m(s, l, along_m) - straight_m;
        if (detour_m < longest_m) detours.emplace_back(detour_m, e);
    }
    if (detours.size() > kMax) {
        std::nth_element(detours.begin(), detours.begin() + kMax, detours.end());
        detours.resize(kMax);
    }
    std::vector<Edge> selected;
    for (const auto& [_, index] : detours) selected.push_back({.index = index});
    const auto by_index = [](const Edge& a, const Edge& b) { return a.index < b.index; };
    std::sort(selected.begin(), selected.end(), by_index);
    for (Edge& edge : selected) {
        const auto known = std::lower_bound(edges_.begin(), edges_.end(), edge, by_index);
        if (known != edges_.end() && known->index == edge.index) edge = *known;
    }
    edges_ = std::move(selected);
    selected_source_ = source_;
    selected_listener_ = listener_;
}

/// Whether an object may have moved in or out of the path over an edge.
bool NearEdges::is_near_change(const DiffractionEdge& edge, std::span<const Bounds> changed) const {
    if (changed.empty()) return false;
    Bounds path;
    for (const glm::dvec3& point : {source_, listener_, edge.point(0), edge.point(edge.length_m)}) {
        path.add(Vec3(point));
    }
    return std::any_of(changed.begin(), changed.end(),
                       [&](const Bounds& volume) { return overlap(volume, path); });
}

}  // namespace aula
