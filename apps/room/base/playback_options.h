#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>

#include "audio/render/headphones.h"
#include "audio/render/renderer.h"
#include "aula/audio/sound_file.h"

namespace aula {

/// The output settings of a scene. Scene::simulation has the settings of the simulation.
struct PlaybackOptions {
    /// A duration without an end: playback until it is stopped.
    static constexpr double kUnlimited_s = std::numeric_limits<double>::infinity();

    double sample_rate_hz = 48000;
    int block = 256;  ///< samples
    OutputFormat output = OutputFormat::binaural;
    int ambisonic_order = 1;             ///< of the reverberation in binaural output, 1 to 3
    bool half_precision_tail = false;    ///< of late reverberation, see RendererConfig
    std::filesystem::path hrtf;          ///< SOFA file; empty: MIT KEMAR
    std::filesystem::path headphones{};  ///< see AuralizerOptions; empty: none
    SampleFormat format = SampleFormat::float32;  ///< of rendered files; PCM passes a limiter
    bool dither = true;                           ///< of PCM, from the simulation's seed
    std::optional<double> duration_s;             ///< if absent: from the scene
    /// See AuralizerOptions.
    std::uint64_t max_memory_bytes = std::numeric_limits<std::uint64_t>::max();
    std::string device;  ///< index or part of a name; empty: the default device
    /// The number of rays was not requested explicitly: live playback reduces it until frames are
    /// in time.
    bool rays_fall = false;
    /// Limit of live responses whose length the scene leaves to the room, which a player sets to
    /// keep frames in time; if absent, 4 s.
    std::optional<double> longest_response_s;
};

/// The HRTF of binaural output at a sample rate; null for other outputs. Throws InputError.
std::shared_ptr<const Hrtf> hrtf_for(const PlaybackOptions& options, double sample_rate_hz);

/// The filter of binaural output for headphones; null if there is none. Throws InputError.
std::shared_ptr<const HeadphoneFilter> headphones_for(const PlaybackOptions& options,
                                                      double sample_rate_hz);

/// Receives the completed share, 0..1; returns false to stop.
using Progress = std::function<bool(double done)>;

}  // namespace aula
