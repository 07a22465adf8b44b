#pragma once

#include <string>
#include <vector>

#include "apps/output/formatted.h"
#include "aula/engine/simulation.h"

namespace aula {

/// Adds a warning if patches are clearly larger than requested, because smaller ones exceed the
/// memory. A choice: up to 1.5 times their size T30 stays within 0.01 s and G within 0.1 dB
/// (`aula scenes/two_rooms.json --report --frames 200 --rays 1000` with `--patch-size 0.5` and
/// `0.75`).
inline void warn_of_patch_size(const Simulation& simulation, float patch_size_m,
                               std::vector<std::string>& warnings) {
    constexpr float kClearly = 1.5F;
    if (patch_size_m <= kClearly * simulation.patch_size_m) return;
    warnings.push_back(
        formatted("patches of %.2f m in place of %.2f m: \"memory_mb\" %d holds no "
                  "smaller ones",
                  static_cast<double>(patch_size_m), static_cast<double>(simulation.patch_size_m),
                  simulation.memory_mb));
}

}  // namespace aula
