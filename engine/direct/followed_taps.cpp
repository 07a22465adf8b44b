#include "engine/direct/followed_taps.h"

#include <algorithm>

namespace aula {

namespace {

/// Multiplies the energies of taps by the ratio of two.
void scale(std::vector<SpecularPath>& taps, const Bands& from, const Bands& to) {
    if (from == to) return;
    Bands ratio;
    for (std::size_t b = 0; b < kBandCount; ++b) ratio[b] = from[b] > 0 ? to[b] / from[b] : 0;
    for (SpecularPath& tap : taps) tap.energy *= ratio;
}

}  // namespace

std::vector<SpecularPath> followed_taps(const EdgePaths& edge_paths,
                                        std::span<const EdgePath> paths, const Bands& model,
                                        const Vec3& source, const Vec3& listener, bool has_moved,
                                        TapMemory& memory,
                                        const std::optional<SpecularPath>& through_walls) {
    const Bands before = memory.levels.energy();
    const Bands& energy = memory.levels.follow(source, listener, model, has_moved);
    const bool is_straight = paths.size() == 1 && paths[0].edges.empty() && paths[0].is_plain;
    if (memory.levels.is_exact() && !through_walls && (paths.empty() || is_straight)) return {};
    std::vector<SpecularPath> taps;
    if (!paths.empty() || through_walls) {
        taps = edge_paths.taps(paths, memory.primary);
        if (through_walls) taps.push_back(*through_walls);
        scale(taps, model, energy);
    } else {
        // What was heard last fades out.
        taps = memory.taps;
        scale(taps, before, energy);
    }
    std::stable_sort(taps.begin(), taps.end(), [](const SpecularPath& a, const SpecularPath& b) {
        return a.length_m < b.length_m;
    });
    return taps;
}

}  // namespace aula
