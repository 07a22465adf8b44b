#pragma once

#include <vector>

#include "engine/base/bands.h"
#include "engine/base/time_bins.h"
#include "engine/estimate/patch_cache.h"
#include "engine/patches/patch_grid.h"
#include "engine/scene/scene.h"

namespace aula {

/// What a patch radiates, to be looked at.
struct PatchEnergy {
    PatchGrid::Cell cell;
    Bands energy;  ///< per unit emitted energy and m2 of the patch
};

/// What the patches radiate within a time after emission; those that sound does not reach, and
/// those that radiate nothing, are left out. [propagation thread]
std::vector<PatchEnergy> patch_energies(const PatchGrid& grid, const PatchCache& cache,
                                        const TimeBins& bins, double begin_s, double end_s);

}  // namespace aula
