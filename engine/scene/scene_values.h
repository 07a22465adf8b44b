#pragma once

#include <functional>
#include <optional>
#include <string>

#include "aula/engine/scene.h"
#include "engine/input/json_reader.h"

namespace aula {

// The basic values of scene files. All functions throw InputError with the location of the error.

/// Of the coordinates of scenes, sources and listeners. The intersection tests of much larger ones
/// overflow.
inline constexpr float kLargestCoordinate_m = 1e6F;

/// A list of 3 numbers in metres, each at most kLargestCoordinate_m.
Vec3 read_point(const JsonReader& json);

/// One number for all bands or a list of 8. Bands with an error that a reader collects keep
/// `on_error`.
Bands read_bands(const JsonReader& json, const NumberRange& range, float on_error);

/// The material that a name means, to start from; throws InputError if there is none.
using KnownMaterial = std::function<Material(const JsonReader& name)>;

/// {"like", "absorption", "scattering", "sound_reduction_db", "source"}; without "like", which
/// `known` finds (empty: an error), absorption is required and scattering is 0.1 if absent. The
/// source is a remark. A band that transmits more than it absorbs is an error.
Material read_material(const std::string& name, const JsonReader& json,
                       const KnownMaterial& known = {});

/// Yaw, pitch and roll from "yaw_deg", "pitch_deg", "roll_deg", each 0 if absent.
Pose read_orientation(const JsonReader& json, const Vec3& position);

/// {"loop", "points": [{"t", "position", "yaw_deg", "pitch_deg", "roll_deg"}]}.
Trajectory read_trajectory(const JsonReader& json);

/// The member "path" of an object, if present.
std::optional<Trajectory> find_trajectory(const JsonReader& json);

}  // namespace aula
