#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "aula/engine/energy_response.h"
#include "engine/rays/ray_scene.h"

namespace aula {

/// Transmission through a wall, which is one face or two. Two faces are one wall if both transmit,
/// their planes are parallel within 20 degrees and they are at most 0.6 m apart. Both directions of
/// passage have equal values.
struct WallTransmission {
    Bands transmission;  ///< share of the incident energy; of two faces the smaller
    Bands scattering;    ///< share that leaves diffusely; of two faces the larger
};

/// Largest distance of two faces that are one wall.
inline constexpr float kThickestWall_m = 0.6F;

/// The transmission of a wall of one face.
WallTransmission wall_of(const RayScene& scene, std::uint32_t face);

/// The same of a wall of two faces.
WallTransmission wall_of(const RayScene& scene, std::uint32_t near, std::uint32_t far);

/// True if two faces at a perpendicular distance are the two faces of one wall.
bool is_one_wall(const RayScene& scene, std::uint32_t near, std::uint32_t far, float distance_m);

/// A point of a transmitting face that sound meets.
struct WallEntry {
    Hit hit;         ///< on the near face
    Vec3 beyond{0};  ///< RayScene::point_beyond: just behind the face
    Vec3 normal{0};  ///< RayScene::facing_normal
};

/// Where sound leaves a wall: opposite to the entry, so that the way back is the same.
struct WallExit {
    Hit hit;         ///< on the face that is left; that of the entry if the wall has one
    Vec3 point{0};   ///< off the far surface
    Vec3 normal{0};  ///< unit, away from the wall
    float thickness_m = 0;
    WallTransmission wall;
};

/// Finds the exits of walls, one for each entry. The transmission is 0 where an opaque face backs a
/// face of the wall; see RayScene::is_backed.
void find_wall_exits(const RayScene& scene, std::span<const WallEntry> entries,
                     std::vector<WallExit>& exits);

/// The share of the energy that reaches the listener straight through walls, as a mean over lines
/// within a spindle between the two points, so that it is continuous while they move. A line
/// through walls counts the product of (1 - s) tau over its walls; a free line, and one that an
/// opaque face or more than 16 faces block, counts nothing: the sound of free lines is the direct
/// sound. Zero if no material transmits. [several threads]
Bands share_through_walls(const RayScene& scene, const Vec3& source, const Vec3& listener);

/// The direct sound through walls, with that share; none if it is zero.
std::optional<SoundPath> path_through_walls(const RayScene& scene, const Vec3& source,
                                            const Vec3& listener, const Bands& attenuation_per_m);

}  // namespace aula
