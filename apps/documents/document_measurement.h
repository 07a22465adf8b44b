#pragma once

#include <array>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "apps/documents/receiver_grid.h"
#include "aula/measurement.h"

namespace aula {

/// Height and spacing of the receivers of a map by default.
inline constexpr double kMapHeight_m = 1.2;
inline constexpr double kMapSpacing_m = 0.5;

/// A line on the number of pairs with larger standard errors than wanted; empty if there are none.
std::string uncertainty_summary(const Measurement& measurement);

/// What is measured in addition.
struct FurtherParameters {
    bool interaural = false;     ///< IACC
    bool third_octaves = false;  ///< T20 to G in third octaves
};

/// Measures all sources at the receivers of a map. Without `frames` until the standard errors are
/// half of the just noticeable differences, or for 256 frames. Returns empty if `progress`, which
/// receives the completed share, requested a stop.
std::optional<Measurement> measure_map(const Scene& scene, const ReceiverGrid& grid,
                                       std::optional<int> frames, const FurtherParameters& further,
                                       const std::function<bool(double done)>& progress);

/// Measures all sources at the named receivers of a report. Without `frames` until the
/// standard errors are a quarter of the just noticeable differences, for 500 frames, or for 80 s of
/// counted work, whichever is first. Returns empty if `progress` requested a stop.
std::optional<Measurement> measure_report(const Scene& scene, std::span<const Pose> receivers,
                                          std::vector<std::string> receiver_names,
                                          std::optional<int> frames,
                                          const FurtherParameters& further,
                                          const std::function<bool(double done)>& progress);

/// Factors of all scattering coefficients, for whose change a report has reverberation times.
inline constexpr std::array<float, 2> kScatteringFactors{0.5F, 2.0F};

/// Measures all sources at the receivers of a report with each of kScatteringFactors: until the
/// standard errors are half of the just noticeable differences, for 256 frames, or for 10 s
/// of counted work, whichever is first. Returns empty if `progress` requested a stop.
std::optional<std::vector<Measurement>> measure_scattering(
    const Scene& scene, std::span<const Pose> receivers, std::optional<int> frames,
    const std::function<bool(double done)>& progress);

}  // namespace aula
