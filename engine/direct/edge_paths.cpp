#include "engine/direct/edge_paths.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <complex>
#include <functional>
#include <glm/geometric.hpp>
#include <numbers>
#include <tuple>
#include <utility>

#include "engine/base/near_field.h"
#include "engine/base/sampling.h"
#include "engine/direct/limits.h"
#include "engine/edges/edge_crossing.h"
#include "engine/edges/edge_field.h"
#include "engine/edges/edge_passage.h"

namespace aula {

namespace {

/// Of a pair, the strongest. A choice: energy() takes the time of all pairs of paths, and where
/// hundreds of single edges are heard limit() bounds their sum.
constexpr std::size_t kMaxPaths = 32;

// Changes of the primary path beyond which it is a different one for the renderer. Within them the
// renderer moves one path, and the delay changes by at most 0.3 ms, the direction by 6 degrees: a
// choice, about what a frame of a walk close to a source changes.
constexpr double kJump_m = 0.1;
constexpr float kJump_rad = 0.1F;

// Paths whose energy is at least this share of the largest may be primary: -6 dB. The primary path
// of the last frame may have half of that, so that it does not change to and fro. A choice.
constexpr double kStrong = 1.0 / 4;
constexpr double kStillStrong = kStrong / 2;

Bands energy_of(const ComplexBands& field) {
    Bands energy;
    for (std::size_t b = 0; b < kBandCount; ++b) {
        energy[b] = static_cast<float>(std::norm(field[b]) / (4 * std::numbers::pi));
    }
    return energy;
}

/// The level of an energy relative to another, in the band where it is highest.
double level_db(const Bands& energy, const Bands& reference) {
    double ratio = 1e-30;
    for (std::size_t b = 0; b < kBandCount; ++b) {
        if (energy[b] > 0 && reference[b] > 0) {
            ratio = std::max(ratio, double{energy[b]} / double{reference[b]});
        }
    }
    return 10 * std::log10(ratio);
}

/// Levels are relative to the strongest path or the primary tap, in the band where they are
/// highest. The level that is at least `weakest_db` and that at most `most` of the levels exceed.
double fade_threshold_db(std::vector<double> levels_db, std::size_t most, double weakest_db) {
    if (levels_db.size() <= most) return weakest_db;
    const auto next = levels_db.begin() + static_cast<std::ptrdiff_t>(most);
    std::nth_element(levels_db.begin(), next, levels_db.end(), std::greater<>());
    return std::max(weakest_db, *next);
}

/// sin(pi x) / (pi x) for x = base_x 2^b in each band.
std::array<double, kBandCount> sinc_of_bands(double base_x) {
    std::array<double, kBandCount> sinc;
    double sine = std::sin(std::numbers::pi * base_x);
    double cosine = std::cos(std::numbers::pi * base_x);
    double x = std::numbers::pi * base_x;
    for (double& value : sinc) {
        value = x < 1e-6 ? 1 : sine / x;
        const double twice = 2 * sine * cosine;  // of the double angle
        cosine = (cosine - sine) * (cosine + sine);
        sine = twice;
        x *= 2;
    }
    return sinc;
}

/// Identifies a path over edges in all frames.
std::uint64_t id_of(const EdgePath& path) {
    std::uint64_t id = 0x65646765 + std::uint64_t{path.reflections};
    for (const std::uint32_t edge : path.edges) id = derive_seed(id, edge);
    return id;
}

double energy_sum(const ComplexBands& field) {
    double sum = 0;
    for (const auto& x : field) sum += std::norm(x);
    return sum;
}

}  // namespace

void EdgePath::scale(double factor) {
    for (auto& x : field) x *= factor;
    for (ComplexBands& face : reflected) {
        for (auto& x : face) x *= factor;
    }
}

/// An edge over which a path from a source to a listener may lead.
struct EdgePaths::Candidate : EdgeCrossing {
    std::uint32_t edge = 0;
    bool is_behind = false;  ///< an end is outside the open angle; its angle is the nearer face's
    std::size_t place = 0;   ///< in NearEdges
    double opening = 0;      ///< of the free width beside the edge, 0 to 1
};

EdgePaths::EdgePaths(const RayScene& scene, const SceneEdges& edges, double speed_of_sound_m_s)
    : scene_(scene), edges_(edges), integral_(speed_of_sound_m_s) {}

std::optional<EdgePaths::Candidate> EdgePaths::candidate(std::uint32_t edge,
                                                         const glm::dvec3& source,
                                                         const glm::dvec3& listener) const {
    const DiffractionEdge& at = edges_[edge];
    WedgePoint at_source = at.coordinates(source, DiffractionEdge::kSourceSide);
    WedgePoint at_listener = at.coordinates(listener, DiffractionEdge::kListenerSide);
    bool is_behind = false;
    for (WedgePoint* const point : {&at_source, &at_listener}) {
        const double behind_rad = point->angle_rad - at.open_angle_rad;
        if (!(behind_rad > 0)) continue;
        is_behind = true;
        point->angle_rad =
            point->angle_rad + behind_rad < 2 * std::numbers::pi ? at.open_angle_rad : 0;
    }
    if (at.is_curved && !at.is_nearest(at_source, at_listener)) return {};
    const auto path = EdgeCrossing::over(at, source, listener, at_source, at_listener);
    if (!path || path->detour_m >= limits::longest_detour_m(path->is_lit)) return {};
    return Candidate{*path, edge, is_behind};
}

/// The diffracted field of an edge. At the two edges of a slot the incident terms cancel the direct
/// sound, or each other, as the slot closes. The terms of the faces add up, and fade out with the
/// slot's width; the whole field does where the straight line passes beside the slot.
EdgeField EdgePaths::field(const Candidate& c, const Bands& attenuation_per_m) const {
    const DiffractionEdge& edge = edges_[c.edge];
    const double turn_rad = std::abs(c.listener.angle_rad - c.source.angle_rad) - std::numbers::pi;
    const double beside = c.share_beside(c.opening);
    EdgeField field = edge.is_curved
                          ? EdgeField{.direct = curved_field(integral_, scene_, edge, turn_rad,
                                                             c.source, c.listener)}
                          : divided_edge_field(integral_, scene_, edge, c.source, c.listener,
                                               {.share = c.opening / beside});
    const double near =
        beside * limits::before_limit(c.detour_m, limits::longest_detour_m(c.is_lit));
    for (std::size_t b = 0; b < kBandCount; ++b) {
        const double share = near * air_loss(c.length_m, attenuation_per_m, b);
        field.direct[b] *= share;
        for (ComplexBands& reflected : field.reflected) reflected[b] *= share;
    }
    return field;
}

/// The width of the opening beside an edge relative to 5 cm, at most 1; 0 if the path over the
/// edge is blocked. Two rays end before the edge, on its two sides. Short ones between them pass
/// around it, and meet a face that closes the open angle, such as the leaf of a shut door in the
/// plane of its wall.
double EdgePaths::opening(const Candidate& c, const Vec3& source, const Vec3& listener) const {
    const EdgePassage passage(edges_[c.edge], c.along_m, c.source.angle_rad, c.listener.angle_rad);
    if (!edges_.visible(listener, passage.point(1)) || !edges_.visible(source, passage.point(0))) {
        return 0;
    }
    return passage.opening(scene_, std::min(c.source.radius_m, c.listener.radius_m));
}

/// Whether two edges are opposite ends of a screen without thickness.
bool EdgePaths::are_of_one_screen(const Candidate& a, const Candidate& b) const {
    const DiffractionEdge& first = edges_[a.edge];
    const DiffractionEdge& second = edges_[b.edge];
    return a.edge != b.edge && first.is_in_screen(second.point(b.along_m)) &&
           second.is_in_screen(first.point(a.along_m));
}

std::vector<EdgePath> EdgePaths::find(const Vec3& source, const Vec3& listener,
                                      const Bands& attenuation_per_m, PairMemory& memory,
                                      std::span<const Bounds> changed) const {
    const glm::dvec3 from(source);
    const glm::dvec3 to(listener);
    NearEdges& near = memory.near;
    std::vector<Candidate> candidates;
    const std::vector<std::uint32_t>& followed = memory.chains.edges;
    for (const std::size_t place : near.begin_frame(edges_, from, to, changed, followed)) {
        auto c = candidate(near[place].index, from, to);
        if (!c) {
            near.set(place, {.index = near[place].index, .is_new = false});
            continue;
        }
        c->place = place;
        const bool counts =
            !c->is_behind && !edges_.is_covered(c->edge, edges_[c->edge].point(c->along_m));
        c->opening = counts ? opening(*c, source, listener) : 0;
        candidates.push_back(*c);
    }

    // Where the straight path passes an edge closely, the coordinates of the edge decide whether it
    // is blocked, as they decide the sign of the diffracted field. A screen seen end-on blocks it
    // only if it does so for the edges at both ends.
    const auto decides = [](const Candidate& c) { return c.opening > 0 && c.is_at_boundary(); };
    const bool is_uncertain = std::any_of(candidates.begin(), candidates.end(), decides);
    const auto passes_screen = [&](const Candidate& c) {
        return std::any_of(candidates.begin(), candidates.end(), [&](const Candidate& other) {
            return decides(other) && other.is_lit && are_of_one_screen(c, other);
        });
    };
    const auto passes = [&](const Candidate& c) {
        return !decides(c) || c.is_lit || passes_screen(c);
    };
    const bool is_lit = is_uncertain ? std::all_of(candidates.begin(), candidates.end(), passes)
                                     : edges_.visible(listener, source);

    std::erase_if(candidates, [&](const Candidate& c) {
        const bool is_blocked = c.opening == 0;
        if (is_blocked) near.set(c.place, {.index = c.edge, .is_new = false});
        return is_blocked;
    });

    std::vector<EdgePath> paths;
    if (is_lit) {
        EdgePath straight{.edges = {},
                          .apexes = {},
                          .is_plain = !edges_.has_small() || scene_.visible(listener, source),
                          .length_m = glm::distance(from, to),
                          .direction = near_direction(from - to),
                          .departure = near_direction(to - from)};
        const double spread_m = std::max(straight.length_m, kNearest_m);
        for (std::size_t b = 0; b < kBandCount; ++b) {
            straight.field[b] =
                std::polar(air_loss(straight.length_m, attenuation_per_m, b) / spread_m,
                           -integral_.wave_number_per_m(b) * straight.length_m);
        }
        paths.push_back(straight);
    }
    Bands strongest = paths.empty() ? Bands{} : energy_of(paths.front().field);
    std::vector<EdgePath> bent;
    for (const Candidate& c : candidates) {
        const glm::dvec3 apex = edges_[c.edge].point(c.along_m);
        const EdgeField of_edge = field(c, attenuation_per_m);
        bent.push_back({.edges = {c.edge},
                        .apexes = {Vec3(apex)},
                        .length_m = c.length_m,
                        .direction = near_direction(apex - to),
                        .departure = near_direction(apex - from),
                        .field = of_edge.direct,
                        .reflected = of_edge.reflected});
        const Bands energy = energy_of(bent.back().field);
        for (std::size_t b = 0; b < kBandCount; ++b) {
            strongest[b] = std::max(strongest[b], energy[b]);
        }
    }
    std::vector<double> levels_db;
    for (const EdgePath& path : bent) {
        levels_db.push_back(level_db(energy_of(path.field), strongest));
    }
    const double threshold_db = fade_threshold_db(levels_db, kMaxPaths, limits::kSilence_db);
    for (std::size_t i = 0; i < bent.size(); ++i) {
        const double above_db = levels_db[i] - threshold_db;
        near.set(
            candidates[i].place,
            {.index = candidates[i].edge, .is_new = false, .is_free = true, .level_db = above_db});
        if (above_db <= 0) continue;
        bent[i].scale(limits::above_threshold(above_db));
        paths.push_back(std::move(bent[i]));
    }
    return paths;
}

/// x = (L_i - L_j) B / c of the lowest octave, with B / c = k / (2 pi sqrt(2)); see energy().
double EdgePaths::coherence_argument(const EdgePath& a, const EdgePath& b) const {
    const double x_per_m =
        integral_.wave_number_per_m(0) / (2 * std::numbers::pi * std::numbers::sqrt2);
    return std::abs(a.length_m - b.length_m) * x_per_m;
}

/// With h the fields and L the lengths, an octave of bandwidth B = centre / sqrt(2) has the mean
/// energy
///
///     E = (1 / 4 pi) sum_ij sinc((L_i - L_j) B / c) Re(h_i conj(h_j)).
Bands EdgePaths::energy(std::span<const EdgePath> paths) const {
    std::array<double, kBandCount> sum{};
    for (std::size_t i = 0; i < paths.size(); ++i) {
        for (std::size_t b = 0; b < kBandCount; ++b) sum[b] += std::norm(paths[i].field[b]);
        for (std::size_t j = 0; j < i; ++j) {
            const auto sinc = sinc_of_bands(coherence_argument(paths[i], paths[j]));
            for (std::size_t b = 0; b < kBandCount; ++b) {
                sum[b] += 2 * sinc[b] *
                          (paths[i].field[b].real() * paths[j].field[b].real() +
                           paths[i].field[b].imag() * paths[j].field[b].imag());
            }
        }
    }
    Bands mean;
    for (std::size_t b = 0; b < kBandCount; ++b) {
        mean[b] = static_cast<float>(std::max(0.0, sum[b]) / (4 * std::numbers::pi));
    }
    return mean;
}

/// Behind obstacles several paths are at most 2.0 dB above free field (boundary elements of a row
/// of columns). In sight they reach 2.5 dB behind a slit (Cornu spiral), and twice that behind a
/// square opening in single frequencies. The faces of an edge that is almost flat add up to 6 dB to
/// one path. Among many edges not all chains are found that cancel the fields of single ones.
Bands EdgePaths::limit(std::span<EdgePath> paths, double straight_m,
                       const Bands& attenuation_per_m) const {
    Bands mean = energy(paths);
    if (paths.size() < 2) return mean;
    const bool is_lit = paths.front().edges.empty();
    const double knee_db = is_lit ? 2.5 : 1;
    const double range_db = is_lit ? 2 : 1.5;
    const double spread_m = std::max(straight_m, kNearest_m);
    for (std::size_t b = 0; b < kBandCount; ++b) {
        double most = std::pow(air_loss(straight_m, attenuation_per_m, b) / spread_m, 2);
        for (const EdgePath& path : paths) {
            const bool is_single_edge = path.edges.size() == 1 && path.is_plain;
            if (is_single_edge) most = std::max(most, std::norm(path.field[b]));
        }
        const double above_db =
            10 * std::log10(4 * std::numbers::pi * double{mean[b]} / most) - knee_db;
        if (!(above_db > 0)) continue;
        const double excess_db = above_db - range_db * std::tanh(above_db / range_db);
        const double factor = std::pow(10, -excess_db / 20);
        for (EdgePath& path : paths) path.field[b] *= factor;
        mean[b] *= static_cast<float>(factor * factor);
    }
    return mean;
}

/// The mean energy is distributed in proportion to
///
///     E_p ~ |h_p + sum_i g_i h_i|^2,    E_i ~ (1 - g_i^2) |h_i|^2,
///
/// where p is the primary path and g_i is sinc((L_i - L_p) B / c) up to its first zero, then 0.
/// Paths of equal length thus become one tap with the phases between them; the sum of all taps does
/// not depend on p.
std::vector<SoundPath> EdgePaths::taps(std::span<const EdgePath> paths, PrimaryTap& last) const {
    if (paths.empty()) return {};
    const EdgePath* primary = &paths.front();
    if (!primary->edges.empty()) {
        double largest = 0;
        for (const EdgePath& path : paths) largest = std::max(largest, energy_sum(path.field));
        const auto is_strong = [&](const EdgePath& path) {
            const bool was_primary = last.path && id_of(path) == id_of(*last.path);
            return energy_sum(path.field) >= largest * (was_primary ? kStillStrong : kStrong);
        };
        for (const EdgePath& path : paths) {
            if (is_strong(path) && (!is_strong(*primary) || path.length_m < primary->length_m)) {
                primary = &path;
            }
        }
    }
    const bool jumps = last.path && id_of(*primary) != id_of(*last.path) &&
                       (std::abs(primary->length_m - last.path->length_m) > kJump_m ||
                        glm::distance(primary->direction, last.path->direction) > kJump_rad);
    // Another key than that of a separate tap of this path.
    if (jumps) last.key = derive_seed(id_of(*primary), last.key);
    last.path = *primary;
    ComplexBands coherent = primary->field;
    const auto tap_of = [](const EdgePath& path, std::uint64_t key, const ComplexBands& field) {
        return SoundPath{
            .kind = path.edges.empty() ? SoundPath::Kind::direct : SoundPath::Kind::bent,
            .order = std::popcount(path.reflections),
            .length_m = static_cast<float>(path.length_m),
            .direction = path.direction,
            .energy = energy_of(field),
            .key = key,
            .edges = static_cast<int>(path.edges.size()),
            .departure = path.departure,
            .apexes = path.apexes};
    };
    std::vector<SoundPath> others;
    for (const EdgePath& path : paths) {
        if (&path == primary) continue;
        SoundPath tap = tap_of(path, id_of(path), path.field);
        const double x = coherence_argument(path, *primary);
        const auto sinc = sinc_of_bands(x);
        for (std::size_t b = 0; b < kBandCount; ++b) {
            const double g = x * static_cast<double>(1U << b) < 1 ? sinc[b] : 0;
            coherent[b] += g * path.field[b];
            tap.energy[b] *= static_cast<float>(1 - g * g);
        }
        others.push_back(tap);
    }
    SoundPath first = tap_of(*primary, last.key, coherent);
    first.is_main = true;

    std::vector<double> levels_db;
    for (const SoundPath& tap : others) levels_db.push_back(level_db(tap.energy, first.energy));
    const double threshold_db = fade_threshold_db(levels_db, kMaxTaps - 1, limits::kWeakestTap_db);
    std::vector<SoundPath> taps{first};
    Bands sum = first.energy;
    for (std::size_t i = 0; i < others.size(); ++i) {
        const double above_db = levels_db[i] - threshold_db;
        if (above_db <= 0) continue;
        others[i].energy *= static_cast<float>(limits::above_threshold(above_db));
        sum += others[i].energy;
        taps.push_back(others[i]);
    }
    const Bands mean = energy(paths);
    Bands scale;
    for (std::size_t b = 0; b < kBandCount; ++b) scale[b] = sum[b] > 0 ? mean[b] / sum[b] : 0;
    for (SoundPath& tap : taps) tap.energy *= scale;
    return taps;
}

}  // namespace aula
