#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <optional>
#include <utility>

#include "engine/base/near_field.h"
#include "engine/direct/chain_search.h"
#include "engine/direct/edge_row.h"
#include "engine/direct/limits.h"

namespace aula {

namespace {

/// Estimates of chains as far below the strongest path between the same points are left out. A
/// choice: 6 dB more than for reflected paths, whose estimate errs by 1.5 dB at one edge alone.
constexpr double kWeakestChain_db = -36;

}  // namespace

std::vector<EdgePath> ChainSearch::find(const Vec3& source, const Vec3& listener,
                                        const PairChains& pair, const Bands& attenuation_per_m,
                                        std::span<const EdgePath> others) const {
    std::vector<std::pair<double, EdgeChain>> chains;  // level
    std::vector<EdgePath> paths;
    double strongest_db = -200;
    for (const EdgePath& path : others) {
        strongest_db = std::max(strongest_db,
                                20 * std::log10(std::abs(path.field[limits::kEstimated]) + 1e-12));
    }
    for (const Sequence& sequence : pair.chains) {
        auto chain = chain_of(sequence, source, listener);
        if (!chain) continue;
        // Where a ray passes an edge closely, the path that leaves the edge out decides.
        for (std::size_t i = 0; i < sequence.size(); ++i) {
            if (!chain->is_at_boundary(i) || chain->is_beside_screen(i)) continue;
            Sequence shorter = sequence;
            shorter.erase(shorter.begin() + static_cast<std::ptrdiff_t>(i));
            const auto is_shorter = [&](const EdgePath& path) { return path.edges == shorter; };
            chain->set_lit(i, shorter.size() == 1
                                  ? std::any_of(others.begin(), others.end(), is_shorter)
                                  : chain_of(shorter, source, listener).has_value());
        }
        const double level_db = chain->estimated_db(integral_) - 20 * std::log10(chain->length_m());
        strongest_db = std::max(strongest_db, level_db);
        chains.emplace_back(level_db, *chain);
        const glm::dvec3 back = chain->last_apex() - glm::dvec3(listener);
        const glm::dvec3 ahead = chain->first_apex() - glm::dvec3(source);
        paths.push_back({.edges = sequence,
                         .apexes = chain->apexes(),
                         .length_m = chain->length_m(),
                         .direction = near_direction(back),
                         .departure = near_direction(ahead),
                         .field = {}});
    }
    for (std::size_t i = 0; i < chains.size(); ++i) {
        const auto& [level_db, chain] = chains[i];
        const double share = limits::above_threshold(level_db - strongest_db - kWeakestChain_db);
        if (share == 0) continue;
        paths[i].field = chain.field(integral_, scene_, attenuation_per_m);
        const double weight = share * chain.opening(edges_);
        for (auto& x : paths[i].field) x *= weight;
    }
    std::erase_if(paths, [](const EdgePath& path) { return path.field == ComplexBands{}; });
    return paths;
}

void ChainSearch::join_rows(const Vec3& source, const Vec3& listener, const PairChains& pair,
                            const Bands& attenuation_per_m, std::vector<EdgePath>& paths) const {
    // Rows that the straight path passes without a bend each change its field by a factor: rows on
    // several sides of it are independent, in any order.
    std::optional<ComplexBands> straight;
    if (!paths.empty() && paths.front().edges.empty()) straight = paths.front().field;
    for (const Sequence& candidates : pair.rows) {
        const auto row = EdgeRow::over(edges_, candidates, source, listener);
        if (!row || !row->is_free(edges_)) continue;
        EdgePath whole = row->path(integral_, scene_, edges_, attenuation_per_m);
        const bool passes_straight = straight && whole.edges.empty();
        for (EdgePath& path : paths) {
            const double rest = 1 - row->covered(path.edges);
            const bool is_factor = passes_straight && path.edges.empty();
            for (std::size_t b = 0; b < kBandCount; ++b) {
                path.field[b] *= is_factor && (*straight)[b] != 0.0
                                     ? rest + whole.field[b] / (*straight)[b]
                                     : rest;
            }
        }
        if (passes_straight) {
            paths.front().is_plain = false;
            continue;
        }
        const auto same = std::find_if(paths.begin(), paths.end(), [&](const EdgePath& path) {
            return path.edges == whole.edges;
        });
        if (same != paths.end()) {
            same->is_plain = false;
            for (std::size_t b = 0; b < kBandCount; ++b) same->field[b] += whole.field[b];
        } else if (whole.edges.empty()) {
            paths.insert(paths.begin(), std::move(whole));
        } else {
            paths.push_back(std::move(whole));
        }
    }
    // A path over a single edge also has terms of reflections.
    std::erase_if(paths, [](const EdgePath& path) {
        return path.edges.size() != 1 && path.field == ComplexBands{};
    });
}

}  // namespace aula
