#include "engine/direct/followed_taps.h"

#include <algorithm>

namespace aula {

namespace {

/// Multiplies the energies of taps by the ratio of two.
void scale(std::vector<SoundPath>& taps, const Bands& from, const Bands& to) {
    if (from == to) return;
    Bands ratio;
    for (std::size_t b = 0; b < kBandCount; ++b) ratio[b] = from[b] > 0 ? to[b] / from[b] : 0;
    for (SoundPath& tap : taps) tap.energy *= ratio;
}

Bands sum_of(const std::vector<SoundPath>& taps) {
    Bands sum;
    for (const SoundPath& tap : taps) sum += tap.energy;
    return sum;
}

/// The taps of the last frame but that through walls, which keep the share of their energy that is
/// not yet that of `model`.
std::vector<SoundPath> fading_beside(const Bands& model, const Bands& before, const Bands& energy,
                                     const std::vector<SoundPath>& last) {
    std::vector<SoundPath> bent = last;
    std::erase_if(bent,
                  [](const SoundPath& tap) { return tap.kind == SoundPath::Kind::through_walls; });
    const Bands all = sum_of(last);
    const Bands of_bent = sum_of(bent);
    Bands from;
    Bands to;
    for (std::size_t b = 0; b < kBandCount; ++b) {
        if (!(of_bent[b] > 0)) continue;
        from[b] = before[b] * of_bent[b] / all[b];
        to[b] = std::max(0.0F, energy[b] - model[b]);
    }
    scale(bent, from, to);
    std::erase_if(bent, [](const SoundPath& tap) { return !(tap.energy.max() > 0); });
    return bent;
}

}  // namespace

std::vector<SoundPath> followed_taps(const EdgePaths& edge_paths, std::span<const EdgePath> paths,
                                     const Bands& model, const Vec3& source, const Vec3& listener,
                                     bool has_moved, TapMemory& memory,
                                     const std::optional<SoundPath>& through_walls) {
    const Bands before = memory.levels.energy();
    const Bands& energy = memory.levels.follow(source, listener, model, has_moved);
    const bool is_straight = paths.size() == 1 && paths[0].edges.empty() && paths[0].is_plain;
    if (memory.levels.is_exact() && !through_walls && (paths.empty() || is_straight)) {
        memory.primary = {};
        if (is_straight) memory.primary.path = paths[0];
        return {};
    }
    std::vector<SoundPath> taps;
    if (!paths.empty()) {
        taps = edge_paths.taps(paths, memory.primary);
        if (through_walls) taps.push_back(*through_walls);
        scale(taps, model, energy);
    } else if (through_walls) {
        // What was heard around edges fades out.
        taps = fading_beside(model, before, energy, memory.taps);
        const Bands fading = sum_of(taps);
        taps.push_back(*through_walls);
        for (std::size_t b = 0; b < kBandCount; ++b) {
            if (fading[b] > 0 || !(model[b] > 0)) continue;
            taps.back().energy[b] *= energy[b] / model[b];
        }
    } else {
        // What was heard last fades out.
        taps = memory.taps;
        scale(taps, before, energy);
    }
    std::stable_sort(taps.begin(), taps.end(), [](const SoundPath& a, const SoundPath& b) {
        return a.length_m < b.length_m;
    });
    return taps;
}

}  // namespace aula
