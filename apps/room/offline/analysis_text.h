#pragma once

#include <optional>
#include <span>
#include <string>

#include "apps/room/offline/response_analysis.h"

namespace aula {

/// Number of parameters of an analysed response: those from T20 to Ts.
inline constexpr std::size_t kAnalysedParameterCount = 7;

/// The value of a parameter by its index, below kAnalysedParameterCount.
std::optional<double> analysed_value(const AnalysedBand& band, std::size_t parameter);

/// An analysed response as a table for display: octaves, decay range, speech transmission index
/// with its class and rating; third octaves, one line each. "-" for absent values.
std::string analysis_table(const ResponseAnalysis& analysis);

/// {"responses":[{"name":..,"sample_rate_hz":..,"length_s":..,"time_zero_s":..,"bands":..,
/// "broadband":..,"STI":..,"STI_class":..,"STI_rating":..,"range_db":{"63":..,..},
/// "third_octaves":{"50":{"T20":..,..,"range_db":..},..},"warnings":[..]}]}, "bands" to "STI" as in
/// report_json(); null for absent values.
std::string analysis_json(std::span<const ResponseAnalysis> analyses);

}  // namespace aula
