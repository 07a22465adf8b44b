#include "engine/direct/chain_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <numbers>
#include <utility>

#include "engine/base/tolerances.h"
#include "engine/direct/edge_row.h"
#include "engine/direct/limits.h"
#include "engine/edges/edge_field.h"
#include "engine/edges/edge_passage.h"
#include "engine/edges/shortest_path.h"

namespace aula {

namespace {

// The search for the chains of a pair: A* with the cost of a path, its length and a penalty for
// each bend. Its bounds are choices: larger ones find weaker chains and take more frames.

/// A bend in the shadow takes at least 6 dB, as the length of a path of 3 m does if it doubles.
constexpr double kPerBend_m = 3;

/// Paths that are continued, each over kMaxNeighbours edges: at most 64 x 64 shortest paths, 4 ms
/// at Budget::kPath.
constexpr int kMaxExpansions = 64;

/// Edges that an edge sees: the nearest.
constexpr std::size_t kMaxNeighbours = 64;

/// Whole paths of which the rays are traced: four for each path that is continued.
constexpr int kMaxTrials = 4 * kMaxExpansions;

/// Chains found, of which ChainSearch::kMaxChains are kept. They are found by cost and kept by
/// estimated level; twice as many bridge the difference.
constexpr std::size_t kMaxFound = 2 * ChainSearch::kMaxChains;

/// Edges of a path. Round a column of 32 sides twelve of them turn it by 135 degrees.
constexpr std::size_t kMaxContacts = 12;

/// Between two edges: twice the longest detour.
constexpr double kLongestSegment_m = 2 * limits::kLongestDetour_m;

// The work of a frame as a number of rays, about 1 us each. After a movement of an object all pairs
// are searched anew, and what they hear may change at once. An end that walks moves by some
// centimetres in a frame: its search may take several. The first search of a pair may do more.
constexpr std::int64_t kRaysUnchanged = 2048;
constexpr std::int64_t kRaysChanged = 8192;
constexpr std::int64_t kFirstRays = 65'536;

/// Points whose visible edges are known: those of 32 pairs. A choice: a byte per edge each.
constexpr std::size_t kMaxPoints = 64;

// Along each of two edges: they see each other if one of nine segments between them is free.
constexpr std::array kPlaces{0.5, 0.05, 0.95};

/// Whether a point lies in the open angle of an edge or on one of its faces.
bool is_beside(const DiffractionEdge& edge, const glm::dvec3& point) {
    const WedgePoint p = edge.coordinates(point);
    return p.radius_m > tolerances::kSame_m &&
           (p.angle_rad < edge.open_angle_rad + tolerances::kOnFace_rad ||
            p.angle_rad > 2 * std::numbers::pi - tolerances::kOnFace_rad);
}

/// A point of an edge that a ray may meet, off its faces, in the middle of the open angle.
Vec3 point_off(const DiffractionEdge& edge, double place) {
    const double middle_rad = edge.open_angle_rad / 2;
    return EdgePassage(edge, place * edge.length_m, middle_rad, middle_rad).point(0);
}

/// One beside the faces of a free edge, on a side.
Vec3 point_beside(const DiffractionEdge& edge, double place, const glm::dvec3& side) {
    const bool is_first = glm::dot(edge.direction(std::numbers::pi / 2), side) > 0;
    const double angle_rad =
        is_first ? std::numbers::pi / 2 : edge.open_angle_rad - std::numbers::pi / 2;
    return EdgePassage(edge, place * edge.length_m, angle_rad, angle_rad).point(0);
}

/// Consecutive edges of a curved surface form one bend.
bool is_one_bend(const DiffractionEdge& a, const DiffractionEdge& b) {
    return a.is_curved && b.is_curved && a.is_along(b);
}

/// Number of bends; see EdgeChain::order.
std::size_t bends_over(std::span<const DiffractionEdge* const> edges) {
    std::size_t bends = edges.size() - EdgeChain::narrow_faces(edges);
    for (std::size_t i = 1; i < edges.size(); ++i)
        if (is_one_bend(*edges[i - 1], *edges[i])) --bends;
    return bends;
}

/// Whether the last edge of a path is the second one of a narrow face: no other shares its bend.
bool ends_at_narrow_face(std::span<const DiffractionEdge* const> edges) {
    return EdgeChain::narrow_faces(edges) > EdgeChain::narrow_faces(edges.first(edges.size() - 1));
}

/// Whether a face at the edge is narrow; see DiffractionEdge::is_across_narrow_face.
bool has_narrow_face(const RayScene& scene, const DiffractionEdge& edge) {
    return std::any_of(edge.triangles.begin(), edge.triangles.end(), [&](std::uint32_t triangle) {
        const auto& corners = scene.triangle(triangle).vertices;
        return std::all_of(corners.begin(), corners.end(), [&](const Vec3& corner) {
            return edge.beside(corner).radius_m < DiffractionEdge::kNarrow_m;
        });
    });
}

double gap_m(const DiffractionEdge& a, const DiffractionEdge& b) {
    return glm::distance(a.point(a.length_m / 2), b.point(b.length_m / 2)) -
           (a.length_m + b.length_m) / 2;
}

}  // namespace

ChainSearch::ChainSearch(const RayScene& scene, const SceneEdges& edges, double speed_of_sound_m_s,
                         int order)
    : scene_(scene),
      edges_(edges),
      integral_(speed_of_sound_m_s),
      order_(static_cast<std::size_t>(order)) {
    for (const DiffractionEdge& edge : edges.all()) {
        is_moving_.push_back(scene.moves(scene.triangle(edge.triangles[0])) ? 1 : 0);
        any_moving_ = any_moving_ || is_moving_.back() != 0;
        shares_bend_.push_back(edge.is_curved || has_narrow_face(scene, edge) ? 1 : 0);
    }
}

void ChainSearch::begin_frame(std::span<const Bounds> changed) {
    budget_ = {Budget::kRay * (changed.empty() ? kRaysUnchanged : kRaysChanged)};
    first_budget_ = {Budget::kRay * kFirstRays};
    if (changed.empty()) return;
    ++scene_changes_;
    forget_seen(changed);
    moving_neighbours_.clear();
    std::erase_if(fixed_neighbours_, [&](const auto& entry) {
        return std::any_of(changed.begin(), changed.end(), [&](const Bounds& bounds) {
            return overlap(entry.second.reach, bounds);
        });
    });
}

bool ChainSearch::begins_anew(const PairChains& pair, const Vec3& source,
                              const Vec3& listener) const {
    return pair.scene_changes != scene_changes_ || !pair.is_between(source, listener) ||
           !follows_curves(pair, source, listener);
}

/// Whether the paths around curved surfaces touch the same edges as at the search. Small movements
/// change them: each edge of a round column is touched from a few centimetres only.
bool ChainSearch::follows_curves(const PairChains& pair, const Vec3& source,
                                 const Vec3& listener) const {
    const auto is_curved = [&](std::uint32_t e) { return edges_[e].is_curved; };
    return std::all_of(pair.curved.begin(), pair.curved.end(),
                       [&](std::uint32_t e) { return is_touched_alone(e, source, listener); }) &&
           std::all_of(pair.chains.begin(), pair.chains.end(), [&](const Sequence& sequence) {
               return std::none_of(sequence.begin(), sequence.end(), is_curved) ||
                      chain_of(sequence, source, listener);
           });
}

/// Whether the shortest path around a curved surface touches one edge alone.
bool ChainSearch::is_touched_alone(std::uint32_t edge, const Vec3& source,
                                   const Vec3& listener) const {
    const DiffractionEdge& at = edges_[edge];
    const WedgePoint from = at.coordinates(source, DiffractionEdge::kSourceSide);
    const WedgePoint to = at.coordinates(listener, DiffractionEdge::kListenerSide);
    return std::max(from.angle_rad, to.angle_rad) <= at.open_angle_rad && at.is_nearest(from, to);
}

void ChainSearch::search(const Vec3& source, const Vec3& listener, PairChains& pair) {
    const bool is_first = !pair.is_searched;
    const bool anew = is_first || begins_anew(pair, source, listener);
    Budget& budget = is_first ? first_budget_ : budget_;
    if (!(anew || pair.open) || !(is_first || budget.is_left())) return;
    if (anew) {
        pair.source = source;
        pair.listener = listener;
        pair.scene_changes = scene_changes_;
        pair.is_searched = true;
        begin(pair, budget);
    }
    const bool is_complete = expand(pair, budget);
    keep_best(pair, budget);
    if (is_complete) pair.open.reset();
}

std::optional<EdgeChain> ChainSearch::chain_of(const Sequence& sequence, const Vec3& source,
                                               const Vec3& listener) const {
    std::vector<const DiffractionEdge*> edges;
    for (const std::uint32_t e : sequence) edges.push_back(&edges_[e]);
    auto chain = EdgeChain::over(edges, source, listener);
    if (chain && (chain->order() > order_ || !chain->is_free(edges_))) chain.reset();
    return chain;
}

/// The edges with the smallest detours between two points.
ChainSearch::Sequence ChainSearch::near_edges(const Vec3& source, const Vec3& listener) const {
    const glm::dvec3 from(source);
    const glm::dvec3 to(listener);
    const double longest_m = glm::distance(from, to) + limits::kLongestDetour_m;
    std::vector<std::pair<double, std::uint32_t>> lengths;
    for (std::uint32_t e = 0; e < edges_.count(); ++e) {
        const DiffractionEdge& edge = edges_[e];
        const glm::dvec3 middle = edge.point(edge.length_m / 2);
        const double length_m =
            glm::distance(from, middle) + glm::distance(middle, to) - edge.length_m;
        if (length_m < longest_m) lengths.emplace_back(length_m, e);
    }
    if (lengths.size() > NearEdges::kMax) {
        std::nth_element(lengths.begin(), lengths.begin() + NearEdges::kMax, lengths.end());
        lengths.resize(NearEdges::kMax);
    }
    Sequence near;
    for (const auto& [_, e] : lengths) {
        if (!edges_.is_covered(e, edges_[e].point(edges_[e].length_m / 2))) near.push_back(e);
    }
    std::sort(near.begin(), near.end());
    return near;
}

/// What is known of the edges that a point sees. The entry used least recently makes room.
ChainSearch::SeenEdges& ChainSearch::seen_from(const Vec3& point) {
    const auto known = std::find_if(seen_.begin(), seen_.end(),
                                    [&](const SeenEdges& seen) { return seen.point == point; });
    SeenEdges* seen = known == seen_.end() ? nullptr : &*known;
    if (seen == nullptr) {
        if (seen_.size() < kMaxPoints) {
            seen = &seen_.emplace_back();
        } else {
            seen = &*std::min_element(
                seen_.begin(), seen_.end(),
                [](const SeenEdges& a, const SeenEdges& b) { return a.last_use < b.last_use; });
        }
        seen->point = point;
        seen->results.assign(edges_.count(), SeenEdges::Result::unknown);
    }
    seen->last_use = ++seen_uses_;
    return *seen;
}

/// Forgets results that a movement in some volumes may have changed.
void ChainSearch::forget_seen(std::span<const Bounds> changed) {
    for (SeenEdges& seen : seen_) {
        for (std::uint32_t e = 0; e < edges_.count(); ++e) {
            if (seen.results[e] == SeenEdges::Result::unknown) continue;
            Bounds between;
            between.add(seen.point);
            between.add(Vec3(edges_[e].start));
            between.add(Vec3(edges_[e].point(edges_[e].length_m)));
            if (std::any_of(changed.begin(), changed.end(),
                            [&](const Bounds& volume) { return overlap(between, volume); })) {
                seen.results[e] = SeenEdges::Result::unknown;
            }
        }
    }
}

bool ChainSearch::is_visible(SeenEdges& seen, std::uint32_t edge, Budget& budget) const {
    SeenEdges::Result& result = seen.results[edge];
    if (result == SeenEdges::Result::unknown) {
        const DiffractionEdge& at = edges_[edge];
        const double nearest =
            std::clamp(at.coordinates(seen.point).along_m / at.length_m, 0.0, 1.0);
        const auto sees = [&](double place) {
            budget.ray();
            return edges_.visible(seen.point, point_off(at, place));
        };
        // From a point in the plane of a screen rays pass on one side of it.
        const auto sees_beside = [&] {
            const glm::dvec3 side = at.direction(std::numbers::pi / 2);
            budget.ray();
            budget.ray();
            return edges_.visible(seen.point, point_beside(at, nearest, side)) ||
                   edges_.visible(seen.point, point_beside(at, nearest, -side));
        };
        const bool is_seen = is_beside(at, seen.point) &&
                             (sees(nearest) || std::any_of(kPlaces.begin(), kPlaces.end(), sees) ||
                              (at.is_in_screen(seen.point) && sees_beside()));
        result = is_seen ? SeenEdges::Result::visible : SeenEdges::Result::hidden;
    }
    return result == SeenEdges::Result::visible;
}

bool ChainSearch::see_each_other(const DiffractionEdge& a, const DiffractionEdge& b,
                                 Budget& budget) const {
    for (const double from : kPlaces) {
        for (const double to : kPlaces) {
            if (!is_beside(a, b.point(to * b.length_m)) ||
                !is_beside(b, a.point(from * a.length_m))) {
                continue;
            }
            budget.ray();
            const double there_rad = a.open_angle_of(b.point(to * b.length_m));
            if (edges_.visible_along_face(point_off(a, from), point_off(b, to),
                                          Vec3(a.normal_at(there_rad)))) {
                return true;
            }
            if (!a.is_in_screen(b.point(to * b.length_m)) ||
                !b.is_in_screen(a.point(from * a.length_m))) {
                continue;
            }
            const glm::dvec3 normal = a.direction(std::numbers::pi / 2);
            for (const glm::dvec3& side : {normal, -normal}) {
                budget.ray();
                if (edges_.visible(point_beside(a, from, side), point_beside(b, to, side))) {
                    return true;
                }
            }
        }
    }
    return false;
}

/// The edges that an edge may see, not yet tested: those whose visibility from it changes with
/// movements, or the others.
ChainSearch::Neighbours ChainSearch::begin_neighbours(std::uint32_t edge, bool moving,
                                                      Budget& budget) const {
    const DiffractionEdge& at = edges_[edge];
    Neighbours found;
    found.reach.add(Vec3(at.start));
    found.reach.add(Vec3(at.point(at.length_m)));
    if (moving && !any_moving_) return found;
    for (std::uint32_t e = 0; e < edges_.count(); ++e) {
        if (e == edge || moving != (is_moving_[edge] != 0 || is_moving_[e] != 0)) continue;
        --budget.work;
        const double distance_m = gap_m(at, edges_[e]);
        if (distance_m <= kLongestSegment_m) found.untested.emplace_back(distance_m, e);
    }
    std::sort(found.untested.begin(), found.untested.end(), std::greater<>());
    return found;
}

void ChainSearch::test_neighbours(std::uint32_t edge, Neighbours& neighbours,
                                  Budget& budget) const {
    while (budget.is_left() && !neighbours.untested.empty()) {
        const std::uint32_t e = neighbours.untested.back().second;
        neighbours.untested.pop_back();
        neighbours.reach.add(Vec3(edges_[e].start));
        neighbours.reach.add(Vec3(edges_[e].point(edges_[e].length_m)));
        if (see_each_other(edges_[edge], edges_[e], budget)) neighbours.edges.push_back(e);
        if (neighbours.edges.size() == kMaxNeighbours) neighbours.untested = {};
    }
}

/// Whether the edges that an edge sees are known, or could be found.
bool ChainSearch::find_neighbours(std::uint32_t edge, Budget& budget) {
    for (const bool moving : {false, true}) {
        auto& table = moving ? moving_neighbours_ : fixed_neighbours_;
        auto found = table.find(edge);
        if (found == table.end()) {
            if (!budget.is_left()) return false;
            found = table.emplace(edge, begin_neighbours(edge, moving, budget)).first;
        }
        test_neighbours(edge, found->second, budget);
        if (!found->second.untested.empty()) return false;
    }
    return true;
}

void ChainSearch::add(OpenChainSearch& open, const PairChains& pair, Sequence sequence,
                      Budget& budget) const {
    // The path over a row takes the place of chains over several of its edges.
    unsigned rows = 0;
    for (const std::uint32_t e : sequence) {
        if ((rows & open.rows_of[e]) != 0) return;
        rows |= open.rows_of[e];
    }
    std::vector<const DiffractionEdge*> edges;
    for (const std::uint32_t e : sequence) edges.push_back(&edges_[e]);
    const std::size_t bends = bends_over(edges);
    const bool is_longest =
        edges.size() == kMaxContacts ||
        (bends == order_ && (shares_bend_[sequence.back()] == 0 || ends_at_narrow_face(edges)));
    if (bends > order_ || (is_longest && open.is_first[sequence.back()] == 0)) return;
    budget.work -= Budget::kPath;
    const glm::dvec3 from(pair.source);
    const glm::dvec3 to(pair.listener);
    const ShortestPath path = shortest_path(to, edges, from);
    if (path.length_m >= glm::distance(from, to) + limits::kLongestDetour_m) return;
    // A path that bends back at an edge of a curved surface, or far from the straight line
    // between the neighbours of an edge, is none.
    for (std::size_t i = 0; i + 1 < edges.size(); ++i) {
        const glm::dvec3 here = edges[i]->point(path.along_m[i]);
        const glm::dvec3 last = i > 0 ? edges[i - 1]->point(path.along_m[i - 1]) : to;
        const glm::dvec3 next = edges[i + 1]->point(path.along_m[i + 1]);
        const double turn_rad = edges[i]->open_angle_of(last) - edges[i]->open_angle_of(next);
        if (std::abs(turn_rad) >= std::numbers::pi) continue;
        const bool is_on_curve = is_one_bend(*edges[i], *edges[i + 1]) ||
                                 (i > 0 && is_one_bend(*edges[i - 1], *edges[i]));
        if (is_on_curve || glm::distance(last, here) + glm::distance(here, next) >=
                               glm::distance(last, next) + limits::kLongestLitBend_m) {
            return;
        }
    }
    open.partials.push(
        {path.length_m + kPerBend_m * static_cast<double>(bends), std::move(sequence), is_longest});
}

void ChainSearch::try_chain(std::vector<std::pair<double, Sequence>>& found, const PairChains& pair,
                            Sequence sequence, Budget& budget) const {
    const auto chain = chain_of(sequence, pair.source, pair.listener);
    budget.work -= Budget::kRay * (chain ? static_cast<std::int64_t>(4 * sequence.size() + 1) : 1);
    if (!chain) return;
    found.emplace_back(20 * std::log10(chain->length_m()) - chain->estimated_db(integral_),
                       std::move(sequence));
}

/// Finds the rows of a pair, and the paths from the listener over the edges that it sees.
void ChainSearch::begin(PairChains& pair, Budget& budget) {
    const glm::dvec3 from(pair.source);
    const glm::dvec3 to(pair.listener);
    const Sequence near = near_edges(pair.source, pair.listener);
    budget.work -= static_cast<std::int64_t>(edges_.count());
    const auto visible_from = [&](const Vec3& point) {
        SeenEdges& seen = seen_from(point);
        std::vector<char> is_seen(edges_.count());
        for (const std::uint32_t e : near) is_seen[e] = is_visible(seen, e, budget) ? 1 : 0;
        return is_seen;
    };
    const std::vector<char> is_last = visible_from(pair.listener);
    OpenChainSearch& open = pair.open.emplace();
    open.is_first = visible_from(pair.source);

    pair.rows = EdgeRow::candidates(edges_, near, from, to);
    open.rows_of.resize(edges_.count());
    for (std::size_t r = 0; r < pair.rows.size(); ++r) {
        const auto row = EdgeRow::over(edges_, pair.rows[r], from, to);
        if (!row || !row->is_free(edges_)) continue;
        for (const std::uint32_t e : pair.rows[r]) {
            if (row->covered({&e, 1}) == 1) open.rows_of[e] |= static_cast<std::uint8_t>(1U << r);
        }
    }
    for (const std::uint32_t e : near) {
        if (is_last[e] != 0) add(open, pair, {e}, budget);
    }
    pair.curved.clear();
    for (const std::uint32_t e : near) {
        if (edges_[e].is_curved && is_touched_alone(e, pair.source, pair.listener)) {
            pair.curved.push_back(e);
        }
    }
}

/// Expands the paths of least cost first, until the search is complete, or the work is done: false.
/// The cost of a path that goes on straight to the source is a lower bound of that over further
/// edges.
bool ChainSearch::expand(PairChains& pair, Budget& budget) {
    OpenChainSearch& open = *pair.open;
    while (!open.partials.empty() && open.expansions < kMaxExpansions && open.trials < kMaxTrials &&
           open.found.size() < kMaxFound) {
        const std::uint32_t end = open.partials.top().edges.back();
        const bool is_longest = open.partials.top().is_longest;
        if (!budget.is_left() || (!is_longest && !find_neighbours(end, budget))) return false;
        const OpenChainSearch::Partial partial = open.partials.top();
        open.partials.pop();
        if (partial.edges.size() > 1 && open.is_first[end] != 0) {
            ++open.trials;
            try_chain(open.found, pair, {partial.edges.rbegin(), partial.edges.rend()}, budget);
        }
        if (is_longest) continue;
        ++open.expansions;
        const auto add_next = [&](std::uint32_t next) {
            if (std::find(partial.edges.begin(), partial.edges.end(), next) != partial.edges.end())
                return;
            Sequence longer = partial.edges;
            longer.push_back(next);
            add(open, pair, std::move(longer), budget);
        };
        for (const auto* table : {&fixed_neighbours_, &moving_neighbours_}) {
            for (const std::uint32_t next : table->at(end).edges) add_next(next);
        }
    }
    return true;
}

/// The chains of a pair: what its search has found so far, and earlier ones that are valid.
void ChainSearch::keep_best(PairChains& pair, Budget& budget) const {
    auto found = pair.open->found;
    for (Sequence& sequence : pair.chains) {
        const bool is_new = std::none_of(found.begin(), found.end(), [&](const auto& other) {
            return other.second == sequence;
        });
        if (is_new) try_chain(found, pair, std::move(sequence), budget);
    }
    std::sort(found.begin(), found.end());
    found.resize(std::min(found.size(), kMaxChains));
    pair.chains.clear();
    pair.edges = pair.curved;
    for (auto& [_, sequence] : found) {
        pair.edges.insert(pair.edges.end(), sequence.begin(), sequence.end());
        pair.chains.push_back(std::move(sequence));
    }
    std::sort(pair.edges.begin(), pair.edges.end());
    pair.edges.erase(std::unique(pair.edges.begin(), pair.edges.end()), pair.edges.end());
}

}  // namespace aula
