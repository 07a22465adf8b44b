#include "engine/trace/deposit_tracer.h"

#include <array>

#include "engine/base/band_vector.h"
#include "process/multiversion.h"

namespace aula {

namespace {

AULA_MULTIVERSION
void add_deposits(const PathBatch& paths, const std::array<std::uint32_t, kLanes>& patch,
                  const std::array<float, kLanes>& factor, const TimeBins& bins, double s_per_m,
                  DepositParts& out) {
    for (std::size_t i = 0; i < paths.count; ++i) {
        const std::size_t bin = bins.index(double{paths.length_m[i]} * s_per_m);
        if (patch[i] == PatchGrid::kNone || bin >= bins.count()) continue;
        Deposit deposit;
        deposit.patch = patch[i];
        deposit.bin = static_cast<std::uint16_t>(bin);
        deposit.ray = static_cast<std::uint8_t>(paths.ray[i]);
        // The random number of the roulette is independent of the diffuse energy.
        deposit.set_energy(factor[i] * load_bands(paths.scattered[i]), paths.roulette[i]);
        if (!deposit.empty()) out.add(deposit);
    }
}

static_assert(kLanes <= 256, "a deposit has eight bits for its ray");

}  // namespace

void DepositTracer::trace(const Emitter& emitter, std::uint64_t frame_seed, int batch,
                          DepositBatch& out) const {
    const auto collect = [&](const PathBatch& paths, int order) {
        count_segments(paths, order, out);
        collect_segments(paths, order, emitter, out);
    };
    follow(emitter, frame_seed, batch, last_order(), Paths::all, collect,
           [&](const PathBatch& paths) { collect_deposits(paths, out); });
}

/// Collects the present segments of paths that neither gather nor image sources find.
void DepositTracer::collect_segments(const PathBatch& paths, int order, const Emitter& emitter,
                                     DepositBatch& out) const {
    const bool specular = traces_specular_of(paths, order);
    const bool after_mirrors = order_is_limited();
    if (!specular && !after_mirrors) return;
    for (std::size_t i = 0; i < paths.count; ++i) {
        const bool collected = paths.diffuse[i] != 0 ? after_mirrors && paths.to_diffuse[i] == 0
                                                     : specular && counts_specular(paths, order, i);
        if (collected) add_segment(paths, i, order, emitter, out);
    }
}

void DepositTracer::collect_deposits(const PathBatch& paths, DepositBatch& out) const {
    std::array<std::uint32_t, kLanes> patch;
    std::array<float, kLanes> factor;
    grid_.find_rows(paths.point, paths.normal, paths.count, patch, factor);
    best_version<add_deposits>(paths, patch, factor, bins_,
                               1 / double{settings().speed_of_sound_m_s}, out.deposits);
}

}  // namespace aula
