#include "engine/rays/wall_crossing.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "engine/base/air_attenuation.h"
#include "engine/base/near_field.h"
#include "engine/base/sampling.h"
#include "engine/base/tolerances.h"
#include "engine/rays/follow_rays.h"

namespace aula {

namespace {

/// Of the path: those of others are hashes, or 0.
constexpr std::uint64_t kKey = 1;

/// The middle of the spindle has the radius of the first Fresnel zone at this wavelength, 1 kHz.
constexpr float kWavelength_m = 0.343F;
constexpr std::size_t kLines = kLanes;
constexpr int kMaxHits = 16;

/// Hits of one line on the same triangle within this distance are one.
constexpr auto kSameHit_m = static_cast<float>(tolerances::kSame_m);

/// A line from the source to the listener on its way through walls.
struct Line {
    Vec3 origin{0};
    float left_m = 0;     ///< of the present half
    bool second = false;  ///< half, after the middle
    int hits = 0;
    std::uint32_t face = kNoTriangle;  ///< the last one met
    bool open = false;                 ///< it may be the near face of a wall of two
    Vec3 at{0};                        ///< where it was met
    bool blocked = false;
    Bands share = Bands::filled(1);
};

void pass(const WallTransmission& wall, Line& line) {
    line.share *= wall.transmission * complement(wall.scattering);
}

/// Counts a face that a line meets.
void meet(const RayScene& scene, std::uint32_t face, const Vec3& at, Line& line) {
    if (!scene.transmits(scene.surface(face).material) || ++line.hits > kMaxHits) {
        line.blocked = true;
        return;
    }
    if (line.face == face && glm::distance(line.at, at) < kSameHit_m) return;
    if (scene.is_backed(at, face)) {
        line.blocked = true;
        return;
    }
    const float distance_m =
        line.open ? std::abs(glm::dot(at - line.at, scene.surface(line.face).normal)) : 0;
    if (line.open && is_one_wall(scene, line.face, face, distance_m)) {
        pass(wall_of(scene, line.face, face), line);
        line.open = false;
    } else {
        if (line.open) pass(wall_of(scene, line.face), line);
        line.open = true;
    }
    line.face = face;
    line.at = at;
}

}  // namespace

WallTransmission wall_of(const RayScene& scene, std::uint32_t face) {
    const std::uint32_t material = scene.surface(face).material;
    return {scene.transmission(material), scene.material(material).scattering};
}

WallTransmission wall_of(const RayScene& scene, std::uint32_t near, std::uint32_t far) {
    WallTransmission wall = wall_of(scene, near);
    const WallTransmission other = wall_of(scene, far);
    for (std::size_t b = 0; b < kBandCount; ++b) {
        wall.transmission[b] = std::min(wall.transmission[b], other.transmission[b]);
        wall.scattering[b] = std::max(wall.scattering[b], other.scattering[b]);
    }
    return wall;
}

bool is_one_wall(const RayScene& scene, std::uint32_t near, std::uint32_t far, float distance_m) {
    const RayScene::Surface& a = scene.surface(near);
    const RayScene::Surface& b = scene.surface(far);
    return distance_m <= kThickestWall_m && scene.transmits(b.material) &&
           std::abs(glm::dot(a.normal, b.normal)) >= RayScene::kParallel;
}

void find_wall_exits(const RayScene& scene, std::span<const WallEntry> entries,
                     std::vector<WallExit>& exits) {
    exits.clear();
    RayLanes rays;
    HitLanes hits;
    for (std::size_t first = 0; first < entries.size(); first += kLanes) {
        const std::size_t count = std::min(kLanes, entries.size() - first);
        for (std::size_t i = 0; i < count; ++i) {
            rays.origin.set(i, entries[first + i].beyond);
            rays.direction.set(i, -entries[first + i].normal);
            rays.max_m[i] = kThickestWall_m;
        }
        scene.intersect(rays, count, hits);
        for (std::size_t i = 0; i < count; ++i) {
            const WallEntry& entry = entries[first + i];
            const Hit hit{hits.triangle[i], hits.distance_m[i], hits.u[i], hits.v[i]};
            const Vec3 onward = -entry.normal;
            const std::uint32_t face = entry.hit.triangle;
            if (!hit.any() || !is_one_wall(scene, face, hit.triangle, hit.distance_m)) {
                exits.push_back({entry.hit, entry.beyond, onward, 0, wall_of(scene, face)});
                if (scene.is_backed(entry.beyond, face)) exits.back().wall.transmission = {};
                continue;
            }
            const Vec3 facing = scene.facing_normal(hit, onward);
            const RayScene::PointOff at =
                RayScene::point_beyond(hit.distance_m, -glm::dot(onward, facing));
            exits.push_back({hit, entry.beyond + at.along_m * onward + at.off_m * facing, -facing,
                             hit.distance_m, wall_of(scene, face, hit.triangle)});
            if (scene.is_backed(entry.beyond, face) ||
                scene.is_backed(exits.back().point, hit.triangle))
                exits.back().wall.transmission = {};
        }
    }
}

Bands share_through_walls(const RayScene& scene, const Vec3& source, const Vec3& listener) {
    if (!scene.transmits()) return {};
    const Vec3 offset = listener - source;
    const float length_m = glm::length(offset);
    if (length_m <= 2 * tolerances::kOffset_m) return {};
    // The lines of the spindle bend in a disc around the middle. Weights fall to 0 at its edge.
    const Vec3 axis = offset / length_m;
    const Vec3 up = std::abs(axis.z) < 0.99F ? Vec3(0, 0, 1) : Vec3(1, 0, 0);
    const Vec3 right = glm::normalize(glm::cross(axis, up));
    const Vec3 above = glm::cross(right, axis);
    const float radius_m = 0.5F * std::sqrt(kWavelength_m * length_m);
    std::array<Vec3, kLines> middle;
    std::array<float, kLines> weight;
    float all = 0;
    for (std::size_t i = 0; i < kLines; ++i) {
        // A sunflower and its mirror image: the lines are the same from either end.
        const auto k = static_cast<float>(i / 2);
        const float square = (k + 0.5F) / static_cast<float>(kLines / 2);
        const Turn turn(std::fmod(k * (std::numbers::phi_v<float> - 1), 1.0F));
        const float r_m = radius_m * std::sqrt(square);
        const float across_m = r_m * (i % 2 == 0 ? turn.cosine : -turn.cosine);
        middle[i] = source + 0.5F * offset + across_m * right + r_m * turn.sine * above;
        weight[i] = (1 - square) * (1 - square);
        all += weight[i];
    }

    std::vector<Line> lines(kLines);
    std::vector<std::size_t> active;
    for (std::size_t i = 0; i < kLines; ++i) {
        // The first half ends just behind the middle, so that no face there is missed.
        lines[i].origin = source;
        lines[i].left_m = glm::distance(source, middle[i]) + tolerances::kOffset_m;
        active.push_back(i);
    }
    const auto segment = [&](std::size_t i) -> Ray {
        const Vec3 end = lines[i].second ? listener : middle[i];
        const Vec3 begin = lines[i].second ? middle[i] : source;
        return {lines[i].origin, glm::normalize(end - begin), lines[i].left_m};
    };
    follow_rays(scene, active, segment, [&](std::size_t i, const Ray& ray, const Hit& hit) {
        Line& line = lines[i];
        if (hit.any()) {
            meet(scene, hit.triangle, line.origin + hit.distance_m * ray.direction, line);
            // A ray that is nearly parallel to the face needs a longer step to pass it.
            const Vec3 normal = scene.facing_normal(hit, ray.direction);
            const RayScene::PointOff at =
                RayScene::point_beyond(hit.distance_m, -glm::dot(ray.direction, normal));
            line.origin += at.along_m * ray.direction + at.off_m * normal;
            line.left_m -= at.along_m;
        }
        if (line.blocked) return false;
        if (hit.any() && line.left_m > 0) return true;
        if (line.second) return false;
        line.second = true;
        line.origin = middle[i];
        line.left_m = glm::distance(middle[i], listener) - tolerances::kOffset_m;
        return true;
    });

    Bands share;
    for (std::size_t i = 0; i < kLines; ++i) {
        Line& line = lines[i];
        if (line.blocked || line.face == kNoTriangle) continue;
        if (line.open) pass(wall_of(scene, line.face), line);
        share += line.share * (weight[i] / all);
    }
    return share;
}

std::optional<SoundPath> path_through_walls(const RayScene& scene, const Vec3& source,
                                            const Vec3& listener, const Bands& attenuation_per_m) {
    const Bands share = share_through_walls(scene, source, listener);
    if (!(share.max() > 0)) return std::nullopt;
    const Vec3 offset = source - listener;
    const float length_m = glm::length(offset);
    const float d_m = std::max(length_m, static_cast<float>(kNearest_m));
    SoundPath path;
    path.kind = SoundPath::Kind::through_walls;
    path.key = kKey;
    path.length_m = length_m;
    path.direction = near_direction(glm::dvec3(offset));
    path.departure = -path.direction;
    path.energy = share * transmission(attenuation_per_m, length_m) *
                  (1 / (4 * std::numbers::pi_v<float> * d_m * d_m));
    return path;
}

}  // namespace aula
