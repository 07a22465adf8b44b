#pragma once

#include <vector>

#include "engine/base/bands.h"
#include "engine/base/time_bins.h"
#include "engine/estimate/patch_cache.h"
#include "engine/patches/patch_grid.h"
#include "engine/scene/scene.h"

namespace aula {

/// The energy that a patch radiates, for display.
struct PatchEnergy {
    PatchGrid::Cell cell;
    Bands energy;  ///< per unit emitted energy and m2 of the patch
};

/// Energies that the patches radiate within a time interval after emission. Patches that sound does
/// not reach and patches that radiate nothing are omitted. [propagation thread]
std::vector<PatchEnergy> patch_energies(const PatchGrid& grid, const PatchCache& cache,
                                        const TimeBins& bins, double begin_s, double end_s);

}  // namespace aula
