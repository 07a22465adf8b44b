#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "apps/session/base/session_options.h"
#include "engine/scene/scene.h"

namespace aula {

/// Session::render: an Auralizer on the exact clock, whose next frames are computed while this
/// thread renders and writes. Sound files' warnings are added to `warnings`.
bool render_offline(const Scene& scene, const SessionOptions& options,
                    const std::filesystem::path& file, const Progress& progress,
                    std::vector<std::string>& warnings);

}  // namespace aula
