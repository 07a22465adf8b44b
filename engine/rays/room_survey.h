#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "engine/rays/ray_scene.h"

namespace aula {

/// Parameters of random walks through a scene.
struct RandomWalks {
    int paths = 0;
    int bounces = 0;  ///< segments of each path
    std::uint64_t seed = 0;
    bool through_moving = true;  ///< true: walks pass moving objects. false: moving objects reflect
                                 ///< at their present positions
    bool through_walls = false;  ///< true: half of the reflections at walls that transmit become
                                 ///< passages
};

/// Traces random walks from the given points, with lossless Lambert reflections. Calls
/// `visit(farthest_m, ray, hit)` at the end of each segment, with the largest distance of the
/// reflections before it from the start, -1 before the first; the hit is empty if the segment
/// escapes. A walk leaves a room only through an
/// opening or, if asked to, a wall that transmits, never by rounding.
///
/// Movable objects may change their position, so segments continue behind them. Where no surface is
/// behind, the object is the wall: that of a moving room, or of a door that is flush with the floor
/// and lets the ray pass through the floor.
void trace_random_walks(const RayScene& scene, std::span<const Vec3> inside,
                        const RandomWalks& walks,
                        const std::function<void(float, const Ray&, const Hit&)>& visit);

/// What movable objects do in connected(): they block sound at their present positions, or nothing.
enum class MovableObjects { block, are_passed };

/// For each source, whether sound can reach one of the listeners: the two see each other, or a
/// random walk of the source, which passes walls that transmit, reaches a point that sees the
/// listener or, on the same side of a triangle, a point of the listener's walks. An opening of less
/// than 1e-5 of a room's surface may be missed.
std::vector<char> connected(const RayScene& scene, std::span<const Vec3> listeners,
                            std::span<const Vec3> sources, std::uint64_t seed,
                            MovableObjects movable = MovableObjects::block);

/// The statistics of a diffuse field in a room.
struct RoomSurvey {
    double mean_free_path_m = 0;  ///< 0 in the open
    Bands mean_absorption;        ///< per reflection; escaping energy counts as absorbed
};

RoomSurvey survey_room(const RayScene& scene, std::span<const Vec3> inside, std::uint64_t seed);

/// The geometry of a room around given points: the surfaces that sound from there reaches, and the
/// enclosed volume.
struct RoomGeometry {
    std::vector<double> area_m2;  ///< [material] reached by sound, both sides of a free panel
    std::vector<double> triangle_area_m2;  ///< [triangle] the same, less exact
    double surface_m2 = 0;                 ///< sum of area_m2
    double open_share = 0;                 ///< share of openings in the room's surface
    /// Openings count as a surface with absorption 1; the mean free path is 4 V / S of the room.
    RoomSurvey field;
    std::optional<double> volume_m3;  ///< empty if too much is open
};

/// Measures the room by random walks, whose reflections are points in the room, and by rays that
/// leave its surface by Lambert's law from uniformly distributed points: those that see a point of
/// the walks, directly or after a reflection. Their mean length is 4 V / S for a room of any shape
/// (Kuttruff, Room Acoustics, 4.2), for any orientation and size of the faces, and with coincident,
/// exterior or missing faces. The volume is computed from the triangles (divergence theorem) where
/// the two agree; otherwise its error is about 1 %, and about `open_share` for a room with
/// openings. All objects are at their present positions.
RoomGeometry measure_room(const RayScene& scene, std::span<const Vec3> inside, std::uint64_t seed);

/// Probability per reflection, 0..1, that a walk from `inside` escapes.
double escape_per_reflection(const RayScene& scene, std::span<const Vec3> inside,
                             std::uint64_t seed);

/// For each position, whether it is outside a room that contains other positions: walks from there
/// escape after far fewer reflections than walks from the most enclosed position.
std::vector<char> outside_room(const RayScene& scene, std::span<const Vec3> positions,
                               std::uint64_t seed);

/// The positions that are not outside such a room, in their order; of more than 64 positions, 64
/// evenly spaced ones are tested.
std::vector<Vec3> inside_room(const RayScene& scene, std::span<const Vec3> positions,
                              std::uint64_t seed);

/// Schroeder's frequency in Hz, 2000 sqrt(T / V): below it single modes are heard, and neither rays
/// nor a diffuse field describe a room (Schroeder and Kuttruff 1962).
double schroeder_frequency_hz(double reverberation_time_s, double volume_m3);

/// Sabine's reverberation time of each band in s, including air absorption; infinite without loss.
Bands sabine_time_s(const RoomSurvey& survey, const Medium& medium);

/// Eyring's reverberation time of each band in s, including air absorption; infinite without loss,
/// 0 in the open.
Bands reverberation_time_s(const RoomSurvey& survey, const Medium& medium);

}  // namespace aula
