#include "engine/direct/reflection_groups.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <glm/geometric.hpp>
#include <numbers>
#include <utility>

#include "engine/base/near_field.h"
#include "engine/base/sampling.h"
#include "engine/direct/followed_taps.h"
#include "engine/direct/limits.h"
#include "engine/edges/edge_crossing.h"
#include "engine/edges/edge_field.h"

namespace aula {

namespace {

bool is_silent(const ComplexBands& field) {
    return std::all_of(field.begin(), field.end(), [](const auto& x) { return x == 0.0; });
}

/// The weight of a group without an image source, by its level relative to the energy of all paths
/// in the band where it is highest.
double weight_of(const Bands& energy, const Bands& total) {
    double ratio = 1e-30;
    for (std::size_t b = 0; b < kBandCount; ++b) {
        if (total[b] > 0) ratio = std::max(ratio, double{energy[b]} / double{total[b]});
    }
    return limits::above_threshold(10 * std::log10(ratio) - limits::kWeakestTap_db);
}

}  // namespace

ReflectionGroups::ReflectionGroups(const RayScene& scene, const SceneEdges& edges,
                                   const EdgePaths& paths, double speed_of_sound_m_s)
    : scene_(scene),
      edges_(edges),
      paths_(paths),
      reflected_(scene, edges, speed_of_sound_m_s),
      integral_(speed_of_sound_m_s) {}

std::map<std::uint32_t, ReflectionGroups::Group> ReflectionGroups::groups_of(
    const ScenePlanes& planes, const glm::dvec3& source, const glm::dvec3& listener,
    std::span<const EdgePath> bent) const {
    std::map<std::uint32_t, Group> groups;
    for (const EdgePath& path : bent) {
        const DiffractionEdge& edge = edges_[path.edges[0]];
        const auto crossing = EdgeCrossing::over(edge, source, listener, edge.coordinates(source),
                                                 edge.coordinates(listener));
        if (!crossing) continue;
        // As in WedgeIntegral: the angles by which the reflections are within the faces.
        const double sum_rad = crossing->source.angle_rad + crossing->listener.angle_rad;
        const std::array<double, 2> within_rad{
            std::numbers::pi - sum_rad, std::numbers::pi - (2 * edge.open_angle_rad - sum_rad)};
        for (std::size_t face = 0; face < 2; ++face) {
            const std::uint32_t plane = planes.of_triangle(edge.triangles[face]);
            // Rays count the reflections of facets.
            if (is_silent(path.reflected[face]) || planes[plane].is_facet()) continue;
            Group& group = groups[plane];
            group.paths.push_back(path);
            group.paths.back().field = path.reflected[face];
            if (crossing->is_beside(within_rad[face])) {
                group.decide(within_rad[face] > 0, edge.triangles[face]);
            }
        }
    }
    return groups;
}

/// The path of an image source, with the field of a rigid plane without losses of the air.
EdgePath ReflectionGroups::image_path(const ScenePlanes::Plane& plane, const glm::dvec3& source,
                                      const glm::dvec3& listener) const {
    const glm::dvec3 offset = plane.mirror(source) - listener;
    EdgePath path{.edges = {},
                  .apexes = {},
                  .length_m = glm::length(offset),
                  .direction = near_direction(offset),
                  .departure = near_direction(plane.mirror(listener) - source)};
    for (std::size_t b = 0; b < kBandCount; ++b) {
        path.field[b] = std::polar(1 / std::max(path.length_m, kNearest_m),
                                   -integral_.wave_number_per_m(b) * path.length_m);
    }
    return path;
}

void ReflectionGroups::complete(std::vector<SoundPath>& paths, const Vec3& source,
                                const Vec3& listener, const FirstOrderImages& images,
                                const OrientedDirectivity& directivity,
                                const Bands& attenuation_per_m, bool has_moved,
                                PairMemory& of_pair) const {
    PairReflections& memory = of_pair.reflections;
    const glm::dvec3 from(source);
    const glm::dvec3 to(listener);
    const bool jumps = memory.is_first || glm::distance(source, memory.source) > limits::kJump_m ||
                       glm::distance(listener, memory.listener) > limits::kJump_m;
    memory.source = source;
    memory.listener = listener;
    memory.is_first = false;
    auto groups = groups_of(images.planes, from, to, memory.bent);
    Bands total;
    for (const SoundPath& path : paths) total += path.energy;
    for (ReflectedEdgePath& found :
         reflected_.find(from, to, images.planes, images.order > 1, directivity, attenuation_per_m,
                         total, has_moved, of_pair)) {
        Group& group = groups[found.plane];
        group.paths.push_back(std::move(found.path));
        if (found.is_image_audible) group.decide(*found.is_image_audible, found.triangle);
    }
    for (const auto& [plane, _] : memory.by_plane) groups.try_emplace(plane);
    for (auto& [plane, group] : groups) {
        const std::uint64_t id = images.ids[plane];
        const auto image = std::find_if(paths.begin(), paths.end(), [&](const SoundPath& path) {
            return path.kind == SoundPath::Kind::image && path.key == id;
        });
        const bool is_found = image != paths.end();
        if (group.is_audible.value_or(is_found)) {
            EdgePath straight = image_path(images.planes[plane], from, to);
            const Bands factor = directivity.factor(straight.departure);
            for (std::size_t b = 0; b < kBandCount; ++b) {
                // With the directivity, the losses of the air and of the surface.
                straight.field[b] *=
                    is_found
                        ? std::sqrt(4 * std::numbers::pi * double{image->energy[b]}) /
                              std::abs(straight.field[b])
                        : mirrored_pressure(scene_.material(scene_.triangle(group.triangle)), b) *
                              std::sqrt(double{factor[b]}) *
                              air_loss(straight.length_m, attenuation_per_m, b);
            }
            group.paths.insert(group.paths.begin(), std::move(straight));
        }
        const bool is_straight = !group.paths.empty() && group.paths.front().edges.empty();
        if (!is_straight) {
            const double weight = weight_of(paths_.energy(group.paths), total);
            if (weight == 0) group.paths.clear();
            for (EdgePath& path : group.paths) path.scale(weight);
        }
        const auto [known, is_new] = memory.by_plane.try_emplace(plane);
        TapMemory& heard = known->second;
        if (is_new && !jumps) {
            // Until now the image source was heard alone.
            const Bands before =
                is_straight ? paths_.energy(std::span(group.paths).first(1)) : Bands{};
            heard.levels.follow(source, listener, before, has_moved);
        }
        heard.taps = followed_taps(paths_, group.paths, paths_.energy(group.paths), source,
                                   listener, has_moved, heard);
        if (heard.taps.empty()) {
            memory.by_plane.erase(known);
            continue;
        }
        if (is_found) paths.erase(image);
        for (SoundPath tap : heard.taps) {
            tap.order = std::max(1, tap.order);
            if (tap.kind == SoundPath::Kind::direct) tap.kind = SoundPath::Kind::image;
            // A primary tap that has not jumped continues the image source.
            tap.key = tap.key == 0 ? id : derive_seed(id, tap.key);
            tap.is_main = false;
            paths.push_back(std::move(tap));
        }
    }
    std::stable_sort(paths.begin(), paths.end(), [](const SoundPath& a, const SoundPath& b) {
        return a.length_m < b.length_m;
    });
}

}  // namespace aula
