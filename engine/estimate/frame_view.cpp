#include "engine/estimate/frame_view.h"

#include <algorithm>

namespace aula {

std::vector<PatchEnergy> patch_energies(const PatchGrid& grid, const PatchCache& cache,
                                        const TimeBins& bins, double begin_s, double end_s) {
    std::vector<PatchEnergy> all;
    if (cache.emitted() == 0) return all;
    const std::size_t first = bins.index(begin_s);
    const std::size_t end = std::min(bins.index(end_s) + 1, bins.count());
    for (std::uint32_t patch = 0; patch < cache.row_count(); ++patch) {
        const PatchCache::Row& row = cache.row(patch);
        const float per_m2 = grid.per_m2(patch);
        if (!row.sum || !(per_m2 > 0)) continue;
        std::array<double, kBandCount> sum{};
        for (std::size_t bin = std::max<std::size_t>(first, row.first_bin);
             bin < std::min<std::size_t>(end, row.end_bin); ++bin) {
            for (std::size_t b = 0; b < kBandCount; ++b)
                sum[b] += double{row.sum[bin * kBandCount + b]};
        }
        PatchEnergy patch_energy{grid.cell(patch), {}};
        const double unit = double{per_m2} / static_cast<double>(cache.emitted());
        for (std::size_t b = 0; b < kBandCount; ++b)
            patch_energy.energy[b] = static_cast<float>(sum[b] * unit);
        if (patch_energy.energy.max() > 0) all.push_back(patch_energy);
    }
    return all;
}

}  // namespace aula
