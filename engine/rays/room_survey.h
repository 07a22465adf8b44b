#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "engine/rays/ray_scene.h"

namespace aula {

/// Random walks through a scene.
struct RandomWalks {
    int paths = 0;
    int bounces = 0;  ///< segments of each path
    std::uint64_t seed = 0;
    bool through_moving = true;  ///< moving objects are passed through, else they are as solid as
                                 ///< the others, where they are now
};

/// Sends rays from the given points through the scene, reflected by Lambert's law without loss, and
/// calls `visit(reflections, ray, hit)` where each segment ends (with no hit where it escapes),
/// after so many reflections. A walk leaves a room only through an opening, never by rounding.
///
/// Objects with a path may not stay where they are: segments go on behind them. Where nothing is
/// behind, they are the wall: of a room that moves, or of a door that stands on the floor and takes
/// the ray through it.
void trace_random_walks(const RayScene& scene, std::span<const Vec3> inside,
                        const RandomWalks& walks,
                        const std::function<void(int, const Ray&, const Hit&)>& visit);

/// For each source, whether sound finds a way to the listener with everything where it is now: they
/// see each other, or random walks of both meet on one side of a triangle. An opening of less than
/// 1e-5 of a room's surface may not be found.
std::vector<char> connected(const RayScene& scene, const Vec3& listener,
                            std::span<const Vec3> sources, std::uint64_t seed);

/// What a diffuse field in a room meets.
struct RoomSurvey {
    double mean_free_path_m = 0;  ///< 0 in the open
    Bands mean_absorption;        ///< per reflection; what escapes is absorbed
};

RoomSurvey survey_room(const RayScene& scene, std::span<const Vec3> inside, std::uint64_t seed);

/// The room round some points: the surfaces that sound from there reaches, and what they enclose.
struct RoomGeometry {
    std::vector<double> area_m2;  ///< [material] that sound reaches, both sides of a free panel
    double surface_m2 = 0;        ///< their sum
    double open_share = 0;        ///< of the room's surface: openings that sound escapes through
    /// With openings as a surface that absorbs all; the mean free path is 4 V / S of the room.
    RoomSurvey field;
    std::optional<double> volume_m3;  ///< empty where too much is open to say
};

/// Measures the room by random walks, which find what surfaces sound reaches, and by rays that
/// leave these surfaces by Lambert's law from points of uniform density: their mean length is 4 V /
/// S for a room of any shape (Kuttruff, Room Acoustics, 4.2), whatever way the faces point, with
/// faces that coincide, that lie outside or that are missing. The volume is that of the triangles
/// themselves (divergence theorem) where the two agree, else within about 1 %, and within about
/// `open_share` of a room with openings. Everything is where it is now.
RoomGeometry measure_room(const RayScene& scene, std::span<const Vec3> inside, std::uint64_t seed);

/// The share of reflections after which a walk from `inside` escapes, 0..1.
double escape_per_reflection(const RayScene& scene, std::span<const Vec3> inside,
                             std::uint64_t seed);

/// For each place whether it is outside a room that others are in: walks from there escape after
/// far fewer reflections than from the best place.
std::vector<char> outside_room(const RayScene& scene, std::span<const Vec3> places,
                               std::uint64_t seed);

/// Sabine's reverberation time in s for each band, air included; infinite without any loss.
Bands sabine_time_s(const RoomSurvey& survey, const Medium& medium);

/// Time in s in which a diffuse field falls by 60 dB, for each band; 0 in the open.
Bands reverberation_time_s(const RoomSurvey& survey, const Medium& medium);

}  // namespace aula
