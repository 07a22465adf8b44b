#pragma once

#include <array>
#include <optional>

#include "apps/room/offline/measurement_error.h"
#include "aula/engine/room_acoustics.h"
#include "aula/measurement.h"

namespace aula {

/// What parameters of a pair depend on besides the response.
struct ParameterContext {
    Vec3 lateral_axis{0, 1, 0};  ///< unit vector
    SpeechConditions speech;     ///< with the level of an omnidirectional source of the same power
    /// The air, for parameters in third octaves; absent: omitted.
    std::optional<Medium> third_octaves{};
};

/// The horizontal axis perpendicular to the direction from a receiver to a source; the receiver's
/// left if the source is above or below it.
Vec3 lateral_axis(const Pose& receiver, const Vec3& source);

/// The same conditions with the speech of an omnidirectional source that has the power of one with
/// a directivity. An octave without sound on axis has the level as the mean over directions.
SpeechConditions with_power_of(SpeechConditions speech, const Directivity& directivity);

/// The parameters of octaves and a speech transmission index, without lateral ones, with the single
/// numbers, without standard errors.
PairParameters acoustic_parameters(const RoomParameters& bands, const std::optional<double>& sti);

/// The parameters of a response, without standard errors.
PairParameters acoustic_parameters(const EnergyResponse& response, const ParameterContext& context);

/// The parameters of the mean of windows, with their standard errors if there are several windows.
PairParameters acoustic_parameters(const WindowedMean& mean, const ParameterContext& context);

}  // namespace aula
