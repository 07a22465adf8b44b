#pragma once

#include <string>
#include <vector>

#include "apps/session/base/formatted.h"
#include "aula/engine/simulation.h"

namespace aula {

/// Adds a warning if patches are larger than requested, because smaller ones exceed the memory.
inline void warn_of_patch_size(const Simulation& simulation, float patch_size_m,
                               std::vector<std::string>& warnings) {
    if (patch_size_m <= simulation.patch_size_m) return;
    warnings.push_back(
        formatted("patches of %.2f m in place of %.2f m: \"memory_mb\" %d holds no "
                  "smaller ones",
                  static_cast<double>(patch_size_m), static_cast<double>(simulation.patch_size_m),
                  simulation.memory_mb));
}

}  // namespace aula
