#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <string>

#include "aula/audio/output_options.h"
#include "aula/audio/sound_file.h"

namespace aula {

/// How a scene is rendered or played. Scene::simulation has the settings of the simulation.
struct PlaybackOptions : OutputOptions {
    /// A duration without an end: playback until it is stopped.
    static constexpr double kUnlimited_s = std::numeric_limits<double>::infinity();

    SampleFormat format = SampleFormat::float32;  ///< of rendered files; PCM passes a limiter
    bool dither = true;                           ///< of PCM, from the simulation's seed
    std::optional<double> duration_s{};           ///< if absent: from the scene
    /// See AuralizerOptions.
    std::uint64_t max_memory_bytes = std::numeric_limits<std::uint64_t>::max();
    std::string device{};  ///< index or part of a name; empty: the default device
    /// The number of rays was not requested explicitly: live playback reduces it until frames are
    /// in time.
    bool rays_fall = false;
    /// Limit of live responses whose length the scene leaves to the room, which a player sets to
    /// keep frames in time; if absent, 4 s.
    std::optional<double> longest_response_s{};
};

/// Receives the completed share, 0..1; returns false to stop.
using Progress = std::function<bool(double done)>;

}  // namespace aula
