#pragma once

#include <vector>

#include "aula/engine/frame.h"
#include "aula/engine/time_bins.h"
#include "engine/cache/patch_cache.h"
#include "engine/patches/patch_grid.h"

namespace aula {

/// Energies that the patches radiate within a time interval after emission. Patches that sound does
/// not reach and patches that radiate nothing are omitted. [propagation thread]
std::vector<PatchEnergy> patch_energies(const PatchGrid& grid, const PatchCache& cache,
                                        const TimeBins& bins, double begin_s, double end_s);

}  // namespace aula
