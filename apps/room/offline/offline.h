#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "apps/room/base/output_resources.h"
#include "apps/room/base/playback_options.h"
#include "apps/room/frames/signals.h"
#include "aula/auralizer.h"
#include "aula/engine/scene.h"
#include "aula/measurement.h"

namespace aula {

/// Renders a scene by an Auralizer on the exact clock, which computes the next frames while the
/// calling thread renders. Sources, listener and objects follow their paths. The same scene,
/// signals, seed and options give the same samples with any block size and any number of threads.
class OfflineRendering {
 public:
    /// `signals` has one signal for each source of the scene. Throws InputError.
    OfflineRendering(const Scene& scene, SignalSet signals, const PlaybackOptions& options);
    ~OfflineRendering();
    OfflineRendering(const OfflineRendering&) = delete;
    OfflineRendering& operator=(const OfflineRendering&) = delete;

    /// Samples of each channel: the options' duration, else until the signals and paths have ended
    /// and the room has rung out.
    std::int64_t samples() const;

    /// Receives the next samples, [channel][sample].
    using Sink = std::function<void(std::span<const std::span<const float>> channels)>;

    /// Renders all samples, once. For PCM formats they pass a limiter. Returns false if `progress`
    /// requested a stop. Throws InputError, Failure.
    bool render(const Sink& sink, const Progress& progress = {});

    /// The state of the room: see Auralizer::status().
    AuralizerStatus status() const;

    /// See Propagation::patch_size_m.
    float patch_size_m() const;

 private:
    struct State;
    std::unique_ptr<State> state_;
};

/// ImpulseResponses with files that have been read before, as before a long measurement.
ImpulseResponses responses_with(const Measurement& measurement, const OutputResources& output);

/// Renders a scene to a WAV file as OfflineRendering. The same scene, seed and options give the
/// same bytes. Returns the warnings about sounds; empty, and leaves no file, if `progress`
/// requested a stop. Throws InputError, Failure.
std::optional<std::vector<std::string>> render_offline(const Scene& scene,
                                                       const PlaybackOptions& options,
                                                       const std::filesystem::path& file,
                                                       const Progress& progress = {});

}  // namespace aula
