#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "apps/session/base/session_options.h"
#include "engine/scene/scene.h"

namespace aula {

/// Session::render. The propagation of the next frames runs on a second thread while this one
/// renders and writes; sound files' warnings are added to `warnings`.
bool render_offline(const Scene& scene, const SessionOptions& options,
                    const std::filesystem::path& file, const Progress& progress,
                    std::vector<std::string>& warnings);

}  // namespace aula
