#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "aula/audio/output_format.h"
#include "aula/engine/scene.h"
#include "aula/measurement.h"
#include "engine/input/json_reader.h"

namespace aula {

/// The most scenes of a dataset.
inline constexpr std::uint64_t kMostScenes = 1'000'000'000;

/// The most pairs of a source and a microphone in a scene: their energy responses are in memory
/// together.
inline constexpr std::uint64_t kMostPairs = 100'000;

/// What all items of a dataset have in common: a part of the manifest, and the first line of the
/// plan.
struct DatasetSettings {
    std::string title = "Room impulse responses";
    std::string licence;
    std::string date = "1970-01-01";  ///< of SOFA files
    std::uint64_t seed = 1;
    Simulation simulation;      ///< without seed; one thread
    std::optional<int> frames;  ///< of a measurement; absent: as `limits` require
    MeasurementLimits limits;
    int max_frames = 2000;  ///< of a measurement with limits
    int sample_rate_hz = 48000;
    OutputFormat format = OutputFormat::mono;
    std::vector<Vec3> array{{0, 0, 0}};  ///< microphones in the axes of the receiver

    /// Channels of a response: of all microphones one after another.
    std::size_t channels() const { return array.size() * channel_count(format); }
};

/// The keys of the settings, which are members of the manifest's and of the plan's root.
const std::vector<std::string>& settings_keys();

/// Reads the settings. Throws InputError.
DatasetSettings read_settings(const JsonReader& root);

/// Name of an output format: "mono", "foa", "toa" or "binaural".
std::string format_name(OutputFormat format);

}  // namespace aula
