#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "apps/session/base/session_options.h"
#include "engine/scene/scene.h"

namespace aula {

/// Session::render: an Auralizer on the exact clock, which computes the next frames while the
/// calling thread renders and writes. Adds the warnings of sound files to `warnings`.
bool render_offline(const Scene& scene, const SessionOptions& options,
                    const std::filesystem::path& file, const Progress& progress,
                    std::vector<std::string>& warnings);

}  // namespace aula
