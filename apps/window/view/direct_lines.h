#pragma once

#include <array>
#include <string>
#include <vector>

#include "aula/engine/energy_response.h"
#include "aula/engine/vec3.h"

namespace aula {

/// A path of the direct sound as a polyline.
struct DirectLine {
    std::vector<Vec3> points;    ///< source, apexes at edges, listener
    float opacity = 1;           ///< by its level; 1 for the loudest primary path
    bool is_primary = false;     ///< the path that gives the direct sound its delay
    bool through_walls = false;  ///< straight, and transmitted by walls
};

/// The paths of the direct sound in a response. Opacity falls linearly with the level, to a tenth
/// at 40 dB below the loudest; paths that are not primary have two thirds of it.
std::vector<DirectLine> direct_lines(const EnergyResponse& response, const Vec3& source,
                                     const Vec3& listener);

/// How the direct sound arrives: "in sight", "around 2 edges", "through walls" or "not in sight".
std::string direct_sound_text(const EnergyResponse& response);

/// The dashes of a dashed line: they begin and end with it and are about `dash_m` long, as are the
/// gaps.
std::vector<std::array<Vec3, 2>> dashes(const Vec3& from, const Vec3& to, float dash_m);

}  // namespace aula
