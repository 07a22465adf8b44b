#include <algorithm>
#include <optional>
#include <tuple>

#include "engine/base/tolerances.h"
#include "engine/direct/edge_row.h"
#include "engine/direct/limits.h"
#include "engine/direct/pair_chains.h"

namespace aula {

namespace {

/// For movements of both ends until the next search is complete: half more than begins it.
constexpr double kMargin_m = 0.15;
static_assert(kMargin_m > double{limits::kSearchAnew_m});

/// Edges of a row: 24 pews of two edges each, or the 30 screens of test_engine "a straight path
/// that touches*", which half as many leave out. A choice: the integral takes a matrix for each.
constexpr std::size_t kMaxMembers = 48;

/// Of a pair: the bits of OpenChainSearch::rows_of.
constexpr std::size_t kMaxRows = 8;
static_assert(kMaxRows <= 8 * sizeof(decltype(OpenChainSearch::rows_of)::value_type));

}  // namespace

/// The edges of the obstacles that the path touches. Without all of them the rest of an obstacle,
/// such as the front and the back of a column, would count as several.
std::vector<std::uint32_t> EdgeRow::touched_obstacles(const SceneEdges& edges) const {
    EdgeRow joined = *this;
    joined.find_obstacles(edges);
    std::vector<std::uint32_t> touched;
    for (const Obstacle& obstacle : joined.obstacles_) {
        const std::span<const Member> members =
            std::span(members_).subspan(obstacle.first, obstacle.last - obstacle.first + 1);
        const bool is_touched = std::any_of(members.begin(), members.end(), [](const Member& m) {
            return m.inside_m > 0 && m.clearance_m < tolerances::kSame_m;
        });
        if (!is_touched) continue;
        for (const Member& member : members) touched.push_back(member.edge);
    }
    return touched;
}

std::vector<std::vector<std::uint32_t>> EdgeRow::candidates(const SceneEdges& edges,
                                                            std::span<const std::uint32_t> near,
                                                            const glm::dvec3& source,
                                                            const glm::dvec3& listener) {
    std::vector<std::vector<std::uint32_t>> rows;
    std::vector<std::vector<std::uint32_t>> blocked;
    std::vector<OpenEdge> rest = open_edges(edges, near);
    std::vector<Placed> known;
    while (rest.size() > 1 && rows.size() < kMaxRows) {
        auto placed = place(edges, rest, source, listener, kMargin_m, &known);
        std::vector<std::uint32_t> row;
        std::vector<std::uint32_t> touched;
        if (placed) {
            touched = placed->touched_obstacles(edges);
            std::vector<Member>& members = placed->members_;
            std::erase_if(members, [](const Member& member) {
                return member.detour_m >= kLongestClearDetour_m + 2 * kMargin_m;
            });
            std::sort(members.begin(), members.end(), [](const Member& a, const Member& b) {
                return std::tie(a.detour_m, a.edge) < std::tie(b.detour_m, b.edge);
            });
            members.resize(std::min(members.size(), kMaxMembers));
            for (const Member& member : members) row.push_back(member.edge);
        }
        std::sort(row.begin(), row.end());
        // If the path of a row is blocked, the obstacles that it touches are left out: the others
        // may form a row whose path is free.
        const std::optional<EdgeRow> whole =
            row.size() > 1 ? over(edges, row, source, listener) : std::nullopt;
        const bool is_row = whole && whole->is_free(edges);
        const std::uint32_t first = rest.front().edge;
        std::erase_if(rest, [&](const OpenEdge& open) {
            const std::uint32_t e = open.edge;
            if (e == first) return true;
            if (is_row) return std::binary_search(row.begin(), row.end(), e);
            return std::find(touched.begin(), touched.end(), e) != touched.end();
        });
        if (row.size() > 1) (is_row ? rows : blocked).push_back(std::move(row));
    }
    // Blocked rows may be free before the next search.
    for (std::vector<std::uint32_t>& row : blocked) {
        const bool is_apart = std::none_of(rows.begin(), rows.end(), [&](const auto& other) {
            return std::find_first_of(row.begin(), row.end(), other.begin(), other.end()) !=
                   row.end();
        });
        if (is_apart && rows.size() < kMaxRows) rows.push_back(std::move(row));
    }
    return rows;
}

}  // namespace aula
