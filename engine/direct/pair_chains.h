#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/geometric.hpp>
#include <optional>
#include <queue>
#include <tuple>
#include <utility>
#include <vector>

#include "aula/engine/scene.h"
#include "engine/direct/limits.h"

namespace aula {

/// A search of ChainSearch between two points that goes on in the next frame.
struct OpenChainSearch {
    /// A path from the listener over some edges, and on to the source.
    struct Partial {
        double cost_m = 0;
        std::vector<std::uint32_t> edges;
        bool is_longest = false;  ///< no further edge may follow

        /// The first of a priority queue has the lowest cost.
        bool operator<(const Partial& other) const {
            return std::tie(other.cost_m, other.edges) < std::tie(cost_m, edges);
        }
    };

    std::vector<char> is_first;         ///< [edge] near, and seen by the source
    std::vector<std::uint8_t> rows_of;  ///< [edge] bits of the rows that hold it whole
    std::priority_queue<Partial> partials;
    /// Chains with their losses, dB.
    std::vector<std::pair<double, std::vector<std::uint32_t>>> found;
    int expansions = 0;
    int trials = 0;
};

/// The chains of edges between a source and a listener, and their last search; see ChainSearch.
struct PairChains {
    std::vector<std::vector<std::uint32_t>> chains;  ///< edges from the source to the listener
    std::vector<std::uint32_t> edges;                ///< of all chains, and `curved`, ascending
    std::vector<std::uint32_t> curved;               ///< edges of curved surfaces touched alone
    std::vector<std::vector<std::uint32_t>> rows;    ///< see EdgeRow
    Vec3 source{0};                                  ///< at the search
    Vec3 listener{0};
    bool is_searched = false;
    std::optional<OpenChainSearch> open;  ///< the search, until it is complete
    std::uint64_t scene_changes = 0;      ///< before the search

    bool is_complete() const { return is_searched && !open; }

    /// Whether the search was between these points, or points near them.
    bool is_between(const Vec3& from, const Vec3& to) const {
        return is_searched && glm::distance(source, from) < limits::kSearchAnew_m &&
               glm::distance(listener, to) < limits::kSearchAnew_m;
    }
};

}  // namespace aula
