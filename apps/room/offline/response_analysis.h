#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "aula/engine/room_acoustics.h"
#include "aula/measurement.h"
#include "engine/response/speech_transmission.h"

namespace aula {

/// How impulse responses are analysed.
struct AnalysisOptions {
    bool third_octaves = false;  ///< true: also in third octaves
    /// Levels at the microphone for the speech transmission index. Absent: it follows from the
    /// modulation transfer of the response alone, without masking, threshold and noise.
    std::optional<ReceivedLevels> speech{};
};

/// Parameters of one band of a measured response.
struct AnalysedBand {
    BandParameters parameters;       ///< without strength, which needs a calibrated source
    std::optional<double> range_db;  ///< from the start of the decay to the noise or to the end
};

/// Parameters of an impulse response, measured or simulated (ISO 3382-1, IEC 60268-16).
struct ResponseAnalysis {
    std::string name;           ///< such as "hall" of hall.wav, or "hall channel 2"
    double sample_rate_hz = 0;  ///< of the response
    double length_s = 0;        ///< of the response
    double zero_s = 0;          ///< time zero, first_arrival()
    PairParameters parameters;  ///< octaves, single numbers and speech transmission index
    std::array<std::optional<double>, kBandCount> range_db;  ///< [band] as AnalysedBand::range_db
    /// For the speech transmission index; empty if an octave from 125 Hz on has no C50.
    std::optional<ModulationTransfers> transfers;
    std::vector<AnalysedBand> third_octaves;  ///< [third octave from 50 Hz on]; empty if omitted
    std::vector<std::string> warnings;        ///< what limits the results, one line each
};

/// Analyses a response. A band whose upper edge is above half of the sample rate has no parameters.
/// Decay times need the decay range of room_parameters(), and a product of band width and time of
/// at least 4 (ISO 3382-1, 5.3.3). Warnings begin with the name. Throws InputError for a response
/// that is silent or shorter than 50 ms after time zero.
ResponseAnalysis analyse_response(const std::string& name, std::span<const float> response,
                                  double sample_rate_hz, const AnalysisOptions& options);

/// Analyses a sound file, [channel]; empty for a silent channel, which another one's warnings name.
/// Throws InputError as read_sound() and analyse_response().
std::vector<std::optional<ResponseAnalysis>> analyse_file(const std::filesystem::path& file,
                                                          const AnalysisOptions& options);

}  // namespace aula
