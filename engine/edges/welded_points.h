#pragma once

#include <bit>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <optional>
#include <vector>

#include "engine/base/mix64.h"
#include "engine/base/tolerances.h"

namespace aula {

/// Values by the hash of their cells, which are cubes of a grid. Cells of equal hash share a list.
class CellTable {
 public:
    explicit CellTable(std::size_t expected)
        : first_(std::bit_ceil(2 * expected + 1), kNone), mask_(first_.size() - 1) {}

    static std::uint64_t hash(const glm::ivec3& cell, std::uint64_t seed = 0) {
        for (const int x : {cell.x, cell.y, cell.z}) {
            seed = mix64(seed ^ static_cast<std::uint32_t>(x));
        }
        return seed;
    }

    void add(std::uint64_t hash, std::uint32_t value) {
        entries_.push_back({hash, value, first_[hash & mask_]});
        first_[hash & mask_] = static_cast<std::uint32_t>(entries_.size() - 1);
    }

    /// Calls `visit` with the values of a cell until it returns true. Returns whether it did.
    template <class Visit>
    bool any(std::uint64_t hash, const Visit& visit) const {
        for (std::uint32_t i = first_[hash & mask_]; i != kNone; i = entries_[i].next) {
            if (entries_[i].hash == hash && visit(entries_[i].value)) return true;
        }
        return false;
    }

 private:
    static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
    struct Entry {
        std::uint64_t hash;
        std::uint32_t value;
        std::uint32_t next;
    };
    std::vector<std::uint32_t> first_;
    std::uint64_t mask_;
    std::vector<Entry> entries_;
};

/// Calls `visit` with each cell that a box touches.
template <class Visit>
void for_cells(const glm::dvec3& low, const glm::dvec3& high, double cell_m, const Visit& visit) {
    const glm::ivec3 from(glm::floor(low / cell_m));
    const glm::ivec3 to(glm::floor(high / cell_m));
    for (int x = from.x; x <= to.x; ++x) {
        for (int y = from.y; y <= to.y; ++y) {
            for (int z = from.z; z <= to.z; ++z) visit(glm::ivec3(x, y, z));
        }
    }
}

/// Points; those within tolerances::kSame_m of another are joined with it.
class WeldedPoints {
 public:
    explicit WeldedPoints(std::size_t expected) : table_(expected) {}

    /// Returns the index of the point, or of that with which it is joined.
    std::uint32_t add(const glm::dvec3& p) {
        std::optional<std::uint32_t> found;
        for_cells(p - tolerances::kSame_m, p + tolerances::kSame_m, kCell_m,
                  [&](const glm::ivec3& cell) {
                      if (found) return;
                      table_.any(CellTable::hash(cell), [&](std::uint32_t i) {
                          if (glm::distance(points_[i], p) > tolerances::kSame_m) return false;
                          found = i;
                          return true;
                      });
                  });
        if (found) return *found;
        points_.push_back(p);
        const auto index = static_cast<std::uint32_t>(points_.size() - 1);
        table_.add(CellTable::hash(glm::ivec3(glm::floor(p / kCell_m))), index);
        return index;
    }

    const glm::dvec3& operator[](std::uint32_t index) const { return points_[index]; }

 private:
    /// A search visits one cell for most points, and few points share one.
    static constexpr double kCell_m = 8 * tolerances::kSame_m;
    CellTable table_;
    std::vector<glm::dvec3> points_;
};

}  // namespace aula
