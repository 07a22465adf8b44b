#include "engine/model/standing_places.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <utility>

namespace aula {

namespace {

/// Places of the grid along the longer side.
constexpr int kGrid = 24;
constexpr float kClosest_m = 0.5F;  ///< spacing of the grid at least

/// A tall person.
constexpr float kHeadroom_m = 1.9F;

/// Free space around a person.
constexpr float kAround_m = 0.5F;

/// Directions that are looked at from a place, and how many of them may meet nothing: a room with a
/// wall of windows is a room, a place before a house is not.
constexpr int kDirections = 64;
constexpr int kMostEscaping = kDirections / 4;

constexpr int kMostFloors = 64;  ///< storeys, tables and double faces under a place

/// Directions that cover the sphere evenly: a Fibonacci lattice.
std::array<Vec3, kDirections> even_directions() {
    std::array<Vec3, kDirections> directions;
    for (int i = 0; i < kDirections; ++i) {
        const double z = 1 - (2.0 * i + 1) / kDirections;
        const double azimuth_rad = std::numbers::pi * (3 - std::sqrt(5.0)) * i;
        const double radius = std::sqrt(1 - z * z);
        directions[static_cast<std::size_t>(i)] = {radius * std::cos(azimuth_rad),
                                                   radius * std::sin(azimuth_rad), z};
    }
    return directions;
}

float distance_m(const RayScene& scene, const Vec3& from, const Vec3& direction) {
    const Ray ray{from, direction};
    Hit hit;
    scene.intersect({&ray, 1}, {&hit, 1});
    return hit.distance_m;
}

/// The least distance to a wall at the height of a place.
float clearance_m(const RayScene& scene, const Vec3& place) {
    constexpr int kAround = 8;  // every 45 degrees: walls, corners
    float least_m = std::numeric_limits<float>::infinity();
    for (int i = 0; i < kAround; ++i) {
        const double azimuth_rad = 2 * std::numbers::pi * i / kAround;
        const Vec3 direction(std::cos(azimuth_rad), std::sin(azimuth_rad), 0);
        least_m = std::min(least_m, distance_m(scene, place, direction));
    }
    return least_m;
}

/// Whether the ground falls on both sides, within the width of a table: a chair or a table, not a
/// floor, a step or a tier.
bool is_on_furniture(const RayScene& scene, const Vec3& place) {
    constexpr int kWidth = 6;                // samples across the widest table
    constexpr float kSample_m = 0.25F;       // half of a chair
    constexpr float kHighestStep_m = 0.21F;  // of stairs
    constexpr int kSides = 4;                // along two axes
    const Vec3 down(0, 0, -1);
    const float fallen_m = distance_m(scene, place, down) + kHighestStep_m;
    const auto samples_to_edge = [&](const Vec3& direction) {
        const float wall_m = distance_m(scene, place, direction);
        for (int samples = 1; samples < kWidth; ++samples) {
            const float away_m = static_cast<float>(samples) * kSample_m;
            if (away_m >= wall_m) break;
            if (distance_m(scene, place + away_m * direction, down) > fallen_m) return samples;
        }
        return kWidth;
    };
    for (int i = 0; i < kSides; ++i) {
        const double azimuth_rad = std::numbers::pi * i / kSides;
        const Vec3 aside(std::cos(azimuth_rad), std::sin(azimuth_rad), 0);
        if (samples_to_edge(aside) + samples_to_edge(-aside) <= kWidth) return true;
    }
    return false;
}

/// The mean distance to what surrounds a place; 0 if too little does, if it is too
/// close, or on furniture.
float openness_m(const RayScene& scene, const Vec3& place) {
    if (clearance_m(scene, place) < kAround_m || is_on_furniture(scene, place)) return 0;
    static const auto directions = even_directions();
    float sum_m = 0;
    int escaping = 0;
    for (const Vec3& direction : directions) {
        const float far_m = distance_m(scene, place, direction);
        if (std::isfinite(far_m)) {
            sum_m += far_m;
        } else if (++escaping > kMostEscaping) {
            return 0;
        }
    }
    return sum_m / static_cast<float>(kDirections - escaping);
}

/// Heights of ears above the floors at a point of the plan: below ceilings, or on the ground in the
/// open.
struct EarHeights {
    std::vector<float> covered_m;
    std::optional<float> open_m;
};

EarHeights ear_heights(const RayScene& scene, float x, float y, const Bounds& bounds) {
    EarHeights heights;
    std::optional<float> above;
    float z = bounds.max.z + 1;
    for (int floor = 0; floor < kMostFloors; ++floor) {
        const Vec3 from(x, y, z);
        const float fall_m = distance_m(scene, from, {0, 0, -1});
        if (!std::isfinite(fall_m)) break;
        z -= fall_m;
        if (!above) {
            heights.open_m = z + kStandingHeight_m;
        } else if (*above - z >= kHeadroom_m) {
            heights.covered_m.push_back(z + std::min(kStandingHeight_m, 0.8F * (*above - z)));
        }
        above = z;
        z -= RayScene::offset_after(2 * glm::length(Vec3(x, y, z)));
    }
    return heights;
}

struct Place {
    Vec3 position{0};
    float openness_m = 0;
};

/// The places on the ground, not on roofs, from the middle on outwards.
std::vector<Vec3> on_ground(const RayScene& scene, std::vector<Vec3> places, const Bounds& bounds) {
    constexpr float kGround = 0.25F;  // share of the height
    const float highest_m = std::lerp(bounds.min.z, bounds.max.z, kGround) + kStandingHeight_m;
    std::erase_if(places, [&](const Vec3& place) {
        return place.z > highest_m || clearance_m(scene, place) < kAround_m ||
               is_on_furniture(scene, place);
    });
    const glm::vec2 middle(0.5F * (bounds.min + bounds.max));
    std::stable_sort(places.begin(), places.end(), [&](const Vec3& a, const Vec3& b) {
        return glm::distance(glm::vec2(a), middle) < glm::distance(glm::vec2(b), middle);
    });
    return places;
}

}  // namespace

std::vector<Vec3> standing_places(const RayScene& scene, const Bounds& bounds) {
    const Vec3 size = bounds.max - bounds.min;
    const float step_m = std::max(std::max(size.x, size.y) / kGrid, kClosest_m);
    std::vector<Place> places;
    std::vector<Vec3> open;
    // Counted: far from the origin a sum of steps may not grow.
    const auto columns = static_cast<int>(size.x / step_m + 0.5F);
    const auto rows = static_cast<int>(size.y / step_m + 0.5F);
    for (int column = 0; column < columns; ++column) {
        const float x = bounds.min.x + (static_cast<float>(column) + 0.5F) * step_m;
        for (int row = 0; row < rows; ++row) {
            const float y = bounds.min.y + (static_cast<float>(row) + 0.5F) * step_m;
            const EarHeights heights = ear_heights(scene, x, y, bounds);
            if (heights.open_m) open.emplace_back(x, y, *heights.open_m);
            for (const float z : heights.covered_m) {
                const Vec3 position(x, y, z);
                const float openness = openness_m(scene, position);
                if (openness > 0) places.push_back({position, openness});
            }
        }
    }
    if (places.empty()) return on_ground(scene, std::move(open), bounds);
    // The room of the most open place: what it sees, and what that sees. Two rows of places see the
    // room of all but a labyrinth.
    std::vector<Vec3> room{
        std::max_element(places.begin(), places.end(), [](const Place& a, const Place& b) {
            return a.openness_m < b.openness_m;
        })->position};
    std::vector<char> taken(places.size(), 0);
    for (std::size_t next = 0; next < room.size() && next < 2 * kGrid; ++next) {
        for (std::size_t i = 0; i < places.size(); ++i) {
            if (taken[i] != 0 || !scene.visible(room[next], places[i].position)) continue;
            taken[i] = 1;
            if (places[i].position != room[0]) room.push_back(places[i].position);
        }
    }
    return room;
}

std::optional<Vec3> source_place(const RayScene& scene, const std::vector<Vec3>& places) {
    if (places.empty()) return std::nullopt;
    const Vec3 middle = places.front();
    // Not in a corner, whose reflections raise the level of low frequencies.
    for (const float clear_m : {3 * kAround_m, 2 * kAround_m, kAround_m}) {
        std::optional<Vec3> best;
        for (const Vec3& place : places) {
            const bool is_level = std::abs(place.z - middle.z) < kAround_m;
            if (!is_level || clearance_m(scene, place) < clear_m || !scene.visible(place, middle))
                continue;
            if (!best || glm::distance(place, middle) > glm::distance(*best, middle)) best = place;
        }
        if (best && *best != middle) return best;
    }
    return middle;
}

std::optional<Vec3> listener_place(const RayScene& scene, const std::vector<Vec3>& places,
                                   const Vec3& source) {
    // Across a living room, and in the first rows of a hall.
    constexpr float kWanted_m = 5;
    std::optional<Vec3> best;
    float best_m = 0;
    for (const Vec3& place : places) {
        const float away_m = glm::distance(place, source);
        if (away_m < 2 * kAround_m || !scene.visible(place, source)) continue;
        if (best && std::abs(away_m - kWanted_m) >= std::abs(best_m - kWanted_m)) continue;
        best = place;
        best_m = away_m;
    }
    return best;
}

}  // namespace aula
