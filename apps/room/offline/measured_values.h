#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "apps/room/offline/response_analysis.h"

namespace aula {

/// The octave values of a measured response.
struct MeasuredResponse {
    std::string name;  ///< empty: none
    PairParameters parameters;
    /// Of a sound file: its speech transmission index is that with the levels at the receiver.
    std::optional<ModulationTransfers> transfers{};
};

/// Analysed responses as CSV (docs/room_measurements.md#measured-values).
std::string measured_csv(std::span<const ResponseAnalysis> analyses);

/// Reads measured values: a CSV file as measured_csv() writes it, or a sound file that is analysed,
/// without its speech transmission index. Appends warnings. Throws InputError.
std::vector<MeasuredResponse> read_measured(const std::filesystem::path& file,
                                            std::vector<std::string>& warnings);

}  // namespace aula
