#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "apps/session/base/session_options.h"
#include "aula/engine/scene.h"

namespace aula {

/// Renders a scene to a WAV file by an Auralizer on the exact clock, which computes the next frames
/// while the calling thread renders and writes. Sources, listener and objects follow their paths.
/// The same scene, seed and options give the same bytes with any block size and any number of
/// threads. Returns the warnings about sounds; empty, and leaves no file, if `progress` requested a
/// stop. Throws InputError, Failure.
std::optional<std::vector<std::string>> render_offline(const Scene& scene,
                                                       const SessionOptions& options,
                                                       const std::filesystem::path& file,
                                                       const Progress& progress = {});

}  // namespace aula
