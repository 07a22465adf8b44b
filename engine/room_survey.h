#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "engine/ray_scene.h"

namespace aula {

/// Sends `paths` rays from the given points through the scene, reflected by Lambert's law without
/// loss for `bounces` segments each, and calls `visit(reflections, ray, hit)` where each segment
/// ends (with no hit where it escapes), after so many reflections. Moving objects are passed
/// through, as they may not stay where they are: segments go on behind them. Where nothing is
/// behind, they are the wall: of a room that moves, or of a door that stands on the floor and takes
/// the ray through it.
void flood(const RayScene& scene, std::span<const Vec3> inside, int paths, int bounces,
           std::uint64_t seed, const std::function<void(int, const Ray&, const Hit&)>& visit);

/// What a diffuse field in a room meets.
struct RoomSurvey {
    double mean_free_path_m = 0;  ///< 0 in the open
    Bands mean_absorption;        ///< per reflection; what escapes is absorbed
};

RoomSurvey survey_room(const RayScene& scene, std::span<const Vec3> inside, std::uint64_t seed);

/// Time in s in which a diffuse field falls by 60 dB, for each band; 0 in the open.
Bands reverberation_time_s(const RoomSurvey& survey, const Medium& medium);

}  // namespace aula
