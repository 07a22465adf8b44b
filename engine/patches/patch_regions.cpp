#include "engine/patches/patch_regions.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <utility>

#include "engine/base/sampling.h"
#include "engine/patches/cell_grid.h"

namespace aula {

namespace {

/// Regions are at least this number of patches wide: with 2 m in a room of 10 m the energy of a
/// region is distributed as late in the response within 0.2 %.
constexpr float kPatchesAcross = 4;
constexpr float kWider = 1.25F;

/// A row belongs to a group if it sees this share of the group's rows, by this number of pairs of
/// places: those on both sides of a door are two groups.
constexpr int kPairs = 16;
constexpr int kSeen = kPairs / 2;

/// Groups of a cell with which a row is compared, the first of which are the largest on the mean.
constexpr std::size_t kCompared = 8;

/// Most regions, as a multiple of those that are wanted. Furniture and columns divide cells into
/// many groups of small areas.
constexpr std::size_t kSmallRegions = 4;

/// A row and its places.
struct Member {
    std::uint64_t key = 0;   ///< of the cell and the direction
    std::uint64_t cell = 0;  ///< the same for all directions
    std::uint32_t row = 0;
    std::span<const PatchGrid::Place> places;
};

/// Divides the members of a cell into groups, whose numbers it returns.
std::vector<std::uint32_t> groups_of(const RayScene& scene, std::span<const Member> members) {
    RandomStream random(derive_seed(members[0].cell, members.size()));
    const auto place = [&](const Member& member) {
        return member.places[random.bits() % member.places.size()].point;
    };
    // In random order: a group begins with rows from all parts of the cell.
    std::vector<std::size_t> order(members.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    for (std::size_t i = order.size(); i > 1; --i)
        std::swap(order[i - 1], order[random.bits() % i]);
    std::vector<std::vector<std::size_t>> groups;
    std::vector<std::uint32_t> group_of(members.size());
    for (const std::size_t i : order) {
        const auto belongs = [&](const std::vector<std::size_t>& group) {
            int seen = 0;
            for (int left = kPairs; left > 0 && seen < kSeen && seen + left >= kSeen; --left) {
                const Member& other = members[group[random.bits() % group.size()]];
                if (scene.visible(place(members[i]), place(other))) ++seen;
            }
            return seen >= kSeen;
        };
        std::size_t g = 0;
        while (g < std::min(groups.size(), kCompared) && !belongs(groups[g])) ++g;
        if (g == kCompared) g = groups.size();
        if (g == groups.size()) groups.emplace_back();
        groups[g].push_back(i);
        group_of[i] = static_cast<std::uint32_t>(g);
    }
    return group_of;
}

/// The places of a grid, by row.
std::vector<Member> members_of(const std::vector<PatchGrid::Place>& sorted) {
    std::vector<Member> members;
    for (std::size_t first = 0, end = 0; first < sorted.size(); first = end) {
        while (end < sorted.size() && sorted[end].row == sorted[first].row) ++end;
        members.push_back({0, 0, sorted[first].row, std::span(sorted).subspan(first, end - first)});
    }
    return members;
}

/// Sets the keys of the cells, and sorts the members by cell. Returns the width of the cells.
float divide(std::vector<Member>& members, const RayScene& scene, const PatchGrid& grid,
             std::size_t most) {
    std::size_t last_count = 0;
    for (float size_m = kPatchesAcross * grid.patch_size_m();; size_m *= kWider) {
        const CellGrid cells(scene, size_m);
        for (Member& member : members) {
            const PatchCell cell = grid.cell(member.row);
            member.key = cells.key_at((cell.low + cell.high) * 0.5F, cell.direction);
            member.cell = CellGrid::cell_of(member.key);
        }
        std::sort(members.begin(), members.end(), [](const Member& a, const Member& b) {
            return a.cell != b.cell ? a.cell < b.cell : a.row < b.row;
        });
        std::vector<std::uint64_t> keys;
        for (const Member& member : members) keys.push_back(member.key);
        std::sort(keys.begin(), keys.end());
        const auto count =
            static_cast<std::size_t>(std::unique(keys.begin(), keys.end()) - keys.begin());
        // Beyond the size of the scene there remain its directions.
        if (count <= most || count == last_count) return cells.size_m();
        last_count = count;
    }
}

}  // namespace

PatchRegions::PatchRegions(const RayScene& scene, const PatchGrid& grid, std::size_t most_large,
                           WorkerPool& workers)
    : of_rows_(grid.size(), kNone) {
    std::vector<PatchGrid::Place> places = grid.places();
    std::stable_sort(places.begin(), places.end(),
                     [](const auto& a, const auto& b) { return a.row < b.row; });
    std::vector<Member> members = members_of(places);
    size_m_ = divide(members, scene, grid, most_large);
    std::vector<std::pair<std::size_t, std::size_t>> cells;  // first member, end
    for (std::size_t i = 0; i < members.size(); ++i) {
        if (i == 0 || members[i].cell != members[i - 1].cell) cells.emplace_back(i, i);
        ++cells.back().second;
    }
    std::vector<std::uint32_t> group_of(members.size());  // of a cell
    workers.run(cells.size(), [&](std::size_t cell) {
        const auto [first, end] = cells[cell];
        const std::vector<std::uint32_t> groups =
            groups_of(scene, std::span(members).subspan(first, end - first));
        std::copy(groups.begin(), groups.end(),
                  group_of.begin() + static_cast<std::ptrdiff_t>(first));
    });

    // The parts of groups that face one direction.
    std::map<std::pair<std::uint32_t, std::uint64_t>, std::vector<std::size_t>> parts;
    for (std::size_t i = 0; i < members.size(); ++i)
        parts[{group_of[i], members[i].key}].push_back(i);
    std::vector<std::pair<double, const std::vector<std::size_t>*>> by_area;
    for (const auto& [key, part] : parts) {
        double area_m2 = 0;
        for (const std::size_t i : part) area_m2 += double{grid.row_area(members[i].row).area_m2};
        by_area.emplace_back(area_m2, &part);
    }
    std::stable_sort(by_area.begin(), by_area.end(),
                     [](const auto& a, const auto& b) { return a.first > b.first; });
    for (const auto& [area_m2, part] : by_area) {
        if (!(area_m2 > 0) || count_ == kSmallRegions * most_large) break;
        for (const std::size_t i : *part)
            of_rows_[members[i].row] = static_cast<std::uint32_t>(count_);
        ++count_;
    }
}

}  // namespace aula
