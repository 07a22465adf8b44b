#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "apps/session/offline/response_analysis.h"

namespace aula {

/// The octave values of a measured response.
struct MeasuredResponse {
    std::string name;  ///< empty: none
    PairParameters parameters;
};

/// Analysed responses as CSV (docs/room_measurements.md#measured-values).
std::string measured_csv(std::span<const ResponseAnalysis> analyses);

/// Reads measured values: a CSV file as measured_csv() writes it, or a sound file that is analysed.
/// Appends warnings. Throws InputError.
std::vector<MeasuredResponse> read_measured(const std::filesystem::path& file,
                                            std::vector<std::string>& warnings);

}  // namespace aula
