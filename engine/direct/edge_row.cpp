#include "engine/direct/edge_row.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <functional>
#include <glm/geometric.hpp>
#include <limits>
#include <tuple>

#include "engine/base/near_field.h"
#include "engine/base/tolerances.h"
#include "engine/direct/edge_chain.h"
#include "engine/direct/limits.h"
#include "engine/edges/edge_field.h"
#include "engine/edges/edge_passage.h"
#include "engine/edges/knife_edges.h"

namespace aula {

namespace {

// Choices where nothing else is said: the integral over a row holds for parallel edges on one side
// of a path, and its errors grow with what these bounds allow.

/// Cosine of the angle between edges of a row, 8 degrees.
constexpr double kParallel = 0.99;

/// Cosine of the angle between the middle of an open angle and up, 72 degrees: the edges at the top
/// of a box open to 45 degrees, those at its foot to 135.
constexpr double kSameSide = 0.3;

// Height of a bend above a free straight path at which that path begins to pass on the other side
// of the obstacles, ten times the uncertainty of rays, and over which the row's share of it fades
// out.
constexpr double kNearStraight_m = 0.01;
constexpr double kOffStraight_m = 0.04;

/// Of rays that would touch edges.
constexpr double kLift_m = tolerances::kApart_m;

/// Where the chord is free as far on both sides of an obstacle, a path passes on its other side.
/// Farther away the chord would meet other obstacles.
constexpr double kBesideObstacle_m = 0.5;

// Edges below the path are independent towards the longest detour, as are edges whose ends are near
// the path. Their shares fade out before: over v = 0.8 to 1 at 500 Hz, and over half a wavelength
// at 570 Hz from the end of an edge, beyond which sound passes beside it.
constexpr double kFade_m = 0.06;
constexpr double kFromEnd_m = 0.3;

/// Smaller shares are none: -60 dB.
constexpr double kLeastShare = 1e-3;

/// Whether a face joins two edges, up to the tolerance of the search for edges.
bool share_face(const DiffractionEdge& a, const glm::dvec3& a_apex, const DiffractionEdge& b,
                const glm::dvec3& b_apex) {
    return a.is_on_face(a.coordinates(b_apex).angle_rad) &&
           b.is_on_face(b.coordinates(a_apex).angle_rad);
}

}  // namespace

std::vector<EdgeRow::OpenEdge> EdgeRow::open_edges(const SceneEdges& edges,
                                                   std::span<const std::uint32_t> row) {
    std::vector<OpenEdge> open;
    for (const std::uint32_t e : row) {
        open.push_back({e, edges[e].axis, edges[e].direction(edges[e].open_angle_rad / 2)});
    }
    return open;
}

/// The edges of a row by their places along the path, with their coordinates, also those that lie
/// outside the limits of a row by a margin.
void EdgeRow::place_members(const SceneEdges& edges, std::span<const OpenEdge> row,
                            double margin_m) {
    const OpenEdge& first = row.front();
    const glm::dvec3 offset = listener_ - source_;
    const double along_m = glm::dot(offset, first.axis);
    const glm::dvec3 ahead = (offset - along_m * first.axis) / across_m_;
    for (const OpenEdge& open : row) {
        const double cosine = glm::dot(open.axis, first.axis);
        if (std::abs(cosine) < kParallel || glm::dot(open.opens_to, up_) < kSameSide) continue;
        const DiffractionEdge& edge = edges[open.edge];
        Member member{.edge = open.edge};
        double place_m = 0.5 * edge.length_m;
        for (int step = 0; step < 3; ++step) {
            member.apex = edge.point(place_m);
            member.across_m = glm::dot(member.apex - source_, ahead);
            const double due_m = along_m * member.across_m / across_m_;
            place_m += (due_m - glm::dot(member.apex - source_, first.axis)) / cosine;
        }
        member.inside_m = std::min(place_m, edge.length_m - place_m);
        const double least_m = WedgeIntegral::kLeastRadius_m - margin_m;
        if (member.inside_m <= -margin_m || member.across_m < least_m ||
            member.across_m > across_m_ - least_m) {
            continue;
        }
        member.along_m = place_m;
        member.apex = edge.point(place_m);
        member.height_m = glm::dot(member.apex - source_, up_);
        const double detour_m = glm::distance(source_, member.apex) +
                                glm::distance(member.apex, listener_) - glm::length(offset);
        if (detour_m >= limits::kLongestDetour_m + 2 * margin_m) continue;
        members_.push_back(member);
    }
    std::sort(members_.begin(), members_.end(), [](const Member& a, const Member& b) {
        return std::tie(a.across_m, a.edge) < std::tie(b.across_m, b.edge);
    });
}

std::optional<EdgeRow> EdgeRow::place(const SceneEdges& edges, std::span<const OpenEdge> row,
                                      const glm::dvec3& source, const glm::dvec3& listener,
                                      double margin_m, std::vector<Placed>* known) {
    EdgeRow placed;
    placed.source_ = source;
    placed.listener_ = listener;
    const OpenEdge& first = row.front();
    const glm::dvec3 offset = listener - source;
    const double along_m = glm::dot(offset, first.axis);
    const glm::dvec3 across = offset - along_m * first.axis;
    placed.across_m_ = glm::length(across);
    if (placed.across_m_ < 2 * WedgeIntegral::kLeastRadius_m) return {};
    placed.up_ = glm::cross(first.axis, across / placed.across_m_);
    if (glm::dot(placed.up_, first.opens_to) < 0) placed.up_ = -placed.up_;
    const auto is_same = [&](const Placed& other) {
        return other.up == placed.up_ && (other.axis == first.axis || other.axis == -first.axis);
    };
    const auto same = known != nullptr ? std::find_if(known->begin(), known->end(), is_same)
                                       : std::vector<Placed>::iterator();
    if (known != nullptr && same != known->end()) {
        std::erase_if(same->members, [&](const Member& member) {
            return !std::binary_search(
                row.begin(), row.end(), OpenEdge{.edge = member.edge},
                [](const OpenEdge& a, const OpenEdge& b) { return a.edge < b.edge; });
        });
        placed.members_ = same->members;
    } else {
        placed.place_members(edges, row, margin_m);
        if (known != nullptr) known->push_back({first.axis, placed.up_, placed.members_});
    }
    if (placed.members_.empty()) return {};
    placed.find_bends();
    placed.find_clearances(along_m);
    return placed;
}

/// The shortest path over the edges is the convex hull of the blocking ones and both ends.
void EdgeRow::find_bends() {
    std::vector<Member*> hull;
    const auto rises = [&](const Member& from, const Member& over, const Member& to) {
        return (over.height_m - from.height_m) * (to.across_m - from.across_m) >
               (to.height_m - from.height_m) * (over.across_m - from.across_m);
    };
    const Member source{};
    Member listener{};
    listener.across_m = across_m_;
    const auto drop_below = [&](const Member& next) {
        while (!hull.empty() &&
               !rises(hull.size() > 1 ? *hull[hull.size() - 2] : source, *hull.back(), next)) {
            hull.pop_back();
        }
    };
    for (Member& member : members_) {
        // Beyond its end an edge blocks nothing, see the margin of place().
        if (member.inside_m <= 0) continue;
        drop_below(member);
        hull.push_back(&member);
    }
    drop_below(listener);
    for (Member* member : hull) member->is_bend = true;
}

/// Lengths along the path, its turns, and how far it is above the other edges. With the planes
/// between its bends unfolded into one the path is straight.
void EdgeRow::find_clearances(double along_m) {
    double unfolded_m = 0;
    Member bend;
    const auto add = [&](const Member& next) {
        unfolded_m += std::hypot(next.across_m - bend.across_m, next.height_m - bend.height_m);
        bend = next;
    };
    for (const Member& member : members_) {
        if (member.is_bend) add(member);
    }
    Member listener;
    listener.across_m = across_m_;
    add(listener);
    stretch_ = std::hypot(along_m, unfolded_m) / unfolded_m;
    double length_m = 0;
    std::size_t begin = 0;
    double from_across_m = 0;
    double from_height_m = 0;
    double last_slope_rad = 0;
    Member* corner = nullptr;
    for (std::size_t end = 0; end <= members_.size(); ++end) {
        const bool is_end = end == members_.size();
        if (!is_end && !members_[end].is_bend) continue;
        const double to_across_m = is_end ? across_m_ : members_[end].across_m;
        const double to_height_m = is_end ? 0 : members_[end].height_m;
        const double slope_rad =
            std::atan2(to_height_m - from_height_m, to_across_m - from_across_m);
        const double segment_m =
            stretch_ * std::hypot(to_height_m - from_height_m, to_across_m - from_across_m);
        if (corner != nullptr) corner->turn_rad = (last_slope_rad - slope_rad) / stretch_;
        for (std::size_t i = begin; i < end; ++i) {
            Member& member = members_[i];
            const double share = (member.across_m - from_across_m) / (to_across_m - from_across_m);
            member.at_m = length_m + share * segment_m;
            const double below_m =
                from_height_m + share * (to_height_m - from_height_m) - member.height_m;
            member.clearance_m = std::max(0.0, below_m * std::cos(slope_rad));
            member.detour_m = 0.5 * member.clearance_m * member.clearance_m /
                              std::abs(segment_m * share * (1 - share));
        }
        length_m += segment_m;
        if (is_end) break;
        members_[end].at_m = length_m;
        corner = &members_[end];
        last_slope_rad = slope_rad;
        from_across_m = to_across_m;
        from_height_m = to_height_m;
        begin = end + 1;
    }
    length_m_ = length_m;
}

/// Pairs of members that a face joins, the nearest ones: the tops of a row of boxes lie in one
/// plane.
std::vector<std::pair<std::size_t, std::size_t>> EdgeRow::joined_by_faces(
    const SceneEdges& edges) const {
    const auto joins = [&](std::size_t a, std::size_t b) {
        return share_face(edges[members_[a].edge], members_[a].apex, edges[members_[b].edge],
                          members_[b].apex);
    };
    std::vector<std::pair<std::size_t, std::size_t>> pairs;
    for (std::size_t i = 0; i < members_.size(); ++i) {
        std::size_t to = i + 1;
        while (to < members_.size() && !joins(i, to)) ++to;
        if (to == members_.size()) continue;
        std::size_t from = to - 1;
        while (from > i && !joins(from, to)) --from;
        if (from == i) pairs.emplace_back(i, to);
    }
    return pairs;
}

/// Drops edges below a face that joins two others: they lie within that obstacle, as the corner of
/// a jamb does behind the leaf of an open door, and the top of a shut leaf below its lintel.
void EdgeRow::drop_covered(const SceneEdges& edges) {
    std::vector<char> is_covered(members_.size());
    for (const auto& [first, last] : joined_by_faces(edges)) {
        const Member& from = members_[first];
        const Member& to = members_[last];
        const double slope = (to.height_m - from.height_m) /
                             std::max(to.across_m - from.across_m, tolerances::kSame_m);
        for (std::size_t k = first + 1; k < last; ++k) {
            const double face_m = from.height_m + slope * (members_[k].across_m - from.across_m);
            if (members_[k].height_m < face_m - tolerances::kSame_m) is_covered[k] = 1;
        }
    }
    std::size_t kept = 0;
    for (std::size_t i = 0; i < members_.size(); ++i)
        if (is_covered[i] == 0) members_[kept++] = members_[i];
    members_.resize(kept);
}

/// The edges of obstacles around which the path bends although it can pass them on their other
/// side, as columns: the chord between the bends beside such an obstacle is free near it.
std::vector<std::uint32_t> EdgeRow::passed_below(const SceneEdges& edges) const {
    EdgeRow joined = *this;
    joined.find_obstacles(edges);
    std::vector<std::uint32_t> passed;
    for (const Obstacle& obstacle : joined.obstacles_) {
        if (obstacle.knife.turn_rad <= limits::kSharpBend_rad) continue;
        glm::dvec3 last = source_;
        glm::dvec3 next = listener_;
        for (std::size_t i = 0; i < obstacle.first; ++i) {
            if (members_[i].is_bend) last = members_[i].apex;
        }
        for (std::size_t i = members_.size(); i-- > obstacle.last + 1;) {
            if (members_[i].is_bend) next = members_[i].apex;
        }
        const double length_m = glm::distance(last, next);
        const glm::dvec3 ahead = (next - last) / length_m;
        const auto on_chord = [&](std::size_t member, double off_m) {
            const double at_m = glm::dot(members_[member].apex - last, ahead) + off_m;
            return Vec3(last + ahead * std::clamp(at_m, kLift_m, length_m - kLift_m));
        };
        if (!edges.visible(on_chord(obstacle.first, -kBesideObstacle_m),
                           on_chord(obstacle.last, kBesideObstacle_m))) {
            continue;
        }
        for (std::size_t i = obstacle.first; i <= obstacle.last; ++i) {
            passed.push_back(members_[i].edge);
        }
    }
    return passed;
}

std::optional<EdgeRow> EdgeRow::over(const SceneEdges& edges, std::span<const std::uint32_t> row,
                                     const glm::dvec3& source, const glm::dvec3& listener) {
    std::vector<OpenEdge> rest = open_edges(edges, row);
    std::optional<EdgeRow> placed;
    while (true) {
        if (rest.size() < 2) return {};
        placed = place(edges, rest, source, listener, 0);
        if (!placed) return {};
        placed->drop_covered(edges);
        const std::vector<std::uint32_t> passed = placed->passed_below(edges);
        if (passed.empty()) break;
        std::erase_if(rest, [&](const OpenEdge& open) {
            return std::find(passed.begin(), passed.end(), open.edge) != passed.end();
        });
    }
    std::vector<Member>& members = placed->members_;
    for (Member& member : members) {
        member.share = smooth_step(member.inside_m / kFromEnd_m) *
                       smooth_step((kLongestClearDetour_m - member.detour_m) / kFade_m);
    }
    std::erase_if(members, [](const Member& m) { return m.share < kLeastShare; });
    placed->find_obstacles(edges);
    double bends_share = 1;
    for (const Member& member : members) {
        if (member.is_bend) bends_share = std::min(bends_share, member.share);
    }
    std::vector<double> shares;
    for (const Obstacle& obstacle : placed->obstacles_) shares.push_back(obstacle.share);
    if (shares.size() < 2) return {};
    std::nth_element(shares.begin(), shares.begin() + 1, shares.end(), std::greater<>());
    const double detour_m = placed->length_m_ - glm::distance(source, listener);
    placed->weight_ =
        std::min(shares[1], bends_share) * limits::before_limit(detour_m, limits::kLongestDetour_m);
    if (placed->weight_ < kLeastShare) return {};
    return placed;
}

/// Joins neighbours to obstacles: edges of one face, and edges that are not independent, as those
/// of a jamb and of the leaf that is hung in it. An edge near the limits of a row is effectively
/// lower.
void EdgeRow::find_obstacles(const SceneEdges& edges) {
    for (std::size_t i = 0; i < members_.size(); ++i) {
        const Member& member = members_[i];
        const Member* const before = i > 0 ? &members_[i - 1] : nullptr;
        const bool joins =
            before != nullptr &&
            (glm::distance(before->apex, member.apex) < DiffractionEdge::kNarrow_m ||
             share_face(edges[before->edge], before->apex, edges[member.edge], member.apex));
        if (!joins) {
            obstacles_.push_back({.first = i, .last = i, .knife = {}});
            obstacles_.back().knife.clearance_m = std::numeric_limits<double>::infinity();
        }
        Obstacle& obstacle = obstacles_.back();
        obstacle.last = i;
        obstacle.is_bend = obstacle.is_bend || member.is_bend;
        obstacle.share = std::max(obstacle.share, member.share);
        obstacle.knife.at_m = 0.5 * (members_[obstacle.first].at_m + member.at_m);
        obstacle.knife.turn_rad += member.turn_rad;
        obstacle.knife.clearance_m =
            std::min(obstacle.knife.clearance_m, member.clearance_m / std::sqrt(member.share));
    }
}

bool EdgeRow::is_free(const SceneEdges& edges) const {
    const auto lifted = [&](const glm::dvec3& point) { return point + kLift_m * up_; };
    const auto sees = [&](const glm::dvec3& from, const glm::dvec3& to) {
        return edges.visible(Vec3(from), Vec3(to)) ||
               edges.visible(Vec3(lifted(from)), Vec3(lifted(to)));
    };
    glm::dvec3 last = source_;
    for (const Member& member : members_) {
        if (!member.is_bend) continue;
        if (!sees(last, lifted(member.apex))) return false;
        last = lifted(member.apex);
    }
    return sees(last, listener_) && opening(edges.scene(), edges) > 0;
}

double EdgeRow::covered(std::span<const std::uint32_t> path) const {
    double share = weight_;
    if (path.empty()) {
        // Where the straight path is free although the row blocks it, it passes on the other side
        // of the obstacles; except within the rounding of rays.
        double height_m = 0;
        for (const Member& member : members_) {
            if (member.is_bend) height_m = std::max(height_m, member.height_m);
        }
        share *= 1 - smooth_step((height_m - kNearStraight_m) / kOffStraight_m);
    }
    for (const std::uint32_t edge : path) {
        const auto member = std::find_if(members_.begin(), members_.end(),
                                         [&](const Member& m) { return m.edge == edge; });
        if (member == members_.end()) return 0;
        share = std::min(share, weight_ * member->share);
    }
    return share;
}

/// The levels of an obstacle alone relative to a knife edge, which has no faces, with all of the
/// path in front of it and behind it.
Bands EdgeRow::levels_over_knife(const Obstacle& obstacle, const WedgeIntegral& integral,
                                 const RayScene& scene, const SceneEdges& edges) const {
    std::vector<const DiffractionEdge*> bends;
    std::vector<const DiffractionEdge*> all;
    glm::dvec3 last = source_;
    glm::dvec3 next = listener_;
    const Member* first_bend = nullptr;
    const Member* last_bend = nullptr;
    std::vector<char> is_bend;
    for (std::size_t i = 0; i < members_.size(); ++i) {
        const Member& member = members_[i];
        if (i < obstacle.first) {
            if (member.is_bend) last = member.apex;
        } else if (i > obstacle.last) {
            if (!member.is_bend) continue;
            next = member.apex;
            break;
        } else {
            all.push_back(&edges[member.edge]);
            is_bend.push_back(member.is_bend ? 1 : 0);
            if (!member.is_bend) continue;
            bends.push_back(&edges[member.edge]);
            if (first_bend == nullptr) first_bend = &member;
            last_bend = &member;
        }
    }
    // The path may lie in a face, with rounding below it.
    constexpr double kOffFace_m = tolerances::kInPlane_m;
    const glm::dvec3 source = first_bend->apex + kOffFace_m * up_ +
                              first_bend->at_m * glm::normalize(last - first_bend->apex);
    const glm::dvec3 listener =
        last_bend->apex + kOffFace_m * up_ +
        (length_m_ - last_bend->at_m) * glm::normalize(next - last_bend->apex);
    ComplexBands field{};
    const auto add = [&](const EdgeChain& chain) {
        const ComplexBands alone = chain.field(integral, scene, Bands{});
        for (std::size_t b = 0; b < kBandCount; ++b) field[b] += alone[b];
    };
    // Edges that the path touches without a bend count as bends: it may lie in a face.
    std::optional<EdgeChain> whole = EdgeChain::over(all, source, listener);
    bool is_touched = whole.has_value();
    for (std::size_t i = 0; i < all.size() && is_touched; ++i) {
        if (whole->is_at_boundary(i)) {
            whole->set_lit(i, false);
        } else {
            is_touched = is_bend[i] != 0;
        }
    }
    if (whole) add(*whole);
    if (!is_touched && bends.size() < all.size()) {
        if (const auto bent = EdgeChain::over(bends, source, listener)) add(*bent);
    }
    const ComplexBands knife = knife_edges({&obstacle.knife, 1}, length_m_, integral);
    Bands levels = Bands::filled(1);
    for (std::size_t b = 0; b < kBandCount; ++b) {
        const double ratio = std::abs(field[b]) * length_m_ / std::abs(knife[b]);
        if (ratio > 0) levels[b] = static_cast<float>(ratio);
    }
    return levels;
}

/// The integral over all obstacles. Sharp bends have the levels of their edges.
ComplexBands EdgeRow::free_field_ratio(const WedgeIntegral& integral, const RayScene& scene,
                                       const SceneEdges& edges) const {
    std::vector<KnifeEdge> knives;
    for (const Obstacle& obstacle : obstacles_) knives.push_back(obstacle.knife);
    ComplexBands ratio = knife_edges(knives, length_m_, integral);
    for (const Obstacle& obstacle : obstacles_) {
        const double sharpness = smooth_step(obstacle.knife.turn_rad / limits::kSharpBend_rad);
        if (sharpness == 0) continue;
        const Bands levels = levels_over_knife(obstacle, integral, scene, edges);
        for (std::size_t b = 0; b < kBandCount; ++b)
            ratio[b] *= std::pow(double{levels[b]}, sharpness);
    }
    return ratio;
}

/// The largest share of an obstacle that the path passes without a sharp bend.
double EdgeRow::grazing_share() const {
    double largest = 0;
    for (const Obstacle& obstacle : obstacles_) {
        const double sharpness = smooth_step(obstacle.knife.turn_rad / limits::kSharpBend_rad);
        largest = std::max(largest, obstacle.share * (1 - sharpness));
    }
    return largest;
}

/// The product of the free widths beside the edges at which the path bends; see EdgePassage.
double EdgeRow::opening(const RayScene& scene, const SceneEdges& edges) const {
    double product = 1;
    glm::dvec3 last = source_;
    for (std::size_t i = 0; i < members_.size(); ++i) {
        const Member& member = members_[i];
        if (!member.is_bend) continue;
        const auto next_bend =
            std::find_if(members_.begin() + static_cast<std::ptrdiff_t>(i) + 1, members_.end(),
                         [](const Member& m) { return m.is_bend; });
        const glm::dvec3 next = next_bend == members_.end() ? listener_ : next_bend->apex;
        const DiffractionEdge& edge = edges[member.edge];
        const EdgePassage passage(edge, member.along_m, edge.open_angle_of(last),
                                  edge.open_angle_of(next));
        product *= passage.opening(
            scene, std::min(glm::distance(last, member.apex), glm::distance(member.apex, next)));
        last = member.apex;
    }
    return product;
}

EdgePath EdgeRow::path(const WedgeIntegral& integral, const RayScene& scene,
                       const SceneEdges& edges, const Bands& attenuation_per_m) const {
    EdgePath path;
    path.is_plain = false;
    glm::dvec3 first = listener_;
    glm::dvec3 last = source_;
    for (const Member& member : members_) {
        if (!member.is_bend) continue;
        if (path.edges.empty()) first = member.apex;
        last = member.apex;
        path.edges.push_back(member.edge);
        path.apexes.emplace_back(member.apex);
    }
    path.length_m = length_m_;
    path.direction = near_direction(last - listener_);
    path.departure = near_direction(first - source_);
    // A path of sharp bends alone is a chain.
    const double grazing = grazing_share();
    if (grazing > 0) {
        const ComplexBands ratio = free_field_ratio(integral, scene, edges);
        const double share = grazing * weight_ * opening(scene, edges) / length_m_;
        for (std::size_t b = 0; b < kBandCount; ++b) {
            path.field[b] = ratio[b] * std::polar(share * air_loss(length_m_, attenuation_per_m, b),
                                                  -integral.wave_number_per_m(b) * length_m_);
        }
    }
    if (grazing < 1 && !path.edges.empty()) {
        std::vector<const DiffractionEdge*> bends;
        for (const std::uint32_t e : path.edges) bends.push_back(&edges[e]);
        if (const auto chain = EdgeChain::over(bends, source_, listener_)) {
            const double share = (1 - grazing) * weight_ * chain->opening(edges);
            const ComplexBands field = chain->field(integral, scene, attenuation_per_m);
            for (std::size_t b = 0; b < kBandCount; ++b) path.field[b] += share * field[b];
        }
    }
    return path;
}

}  // namespace aula
