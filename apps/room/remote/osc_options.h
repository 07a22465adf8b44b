#pragma once

#include <optional>
#include <string>

#include "aula/engine/scene.h"

namespace aula {

/// Where OSC messages are received, and how coordinates and head trackers are read.
struct OscOptions {
    std::string address{};                ///< [ADDRESS:]PORT
    std::optional<Vec3> adm_origin{};     ///< m; if absent: the listener's first position
    std::optional<float> adm_radius_m{};  ///< if absent: half of the room's longest side
    bool head_invert = false;             ///< head trackers send the inverse rotation
};

/// The cube of a room that the coordinates -1 to 1 of ADM-OSC cover.
struct AdmRegion {
    AdmRegion(const Scene& scene, const OscOptions& options);

    Vec3 origin{0};      ///< m, its centre
    float radius_m = 1;  ///< half of its side

    /// One line, for instance "ADM-OSC: origin 4, 3, 1.7 m, radius 5 m".
    std::string text() const;
};

}  // namespace aula
