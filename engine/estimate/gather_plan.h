#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace aula {

/// Gather rays of a receiver at most: those of each for one window of frames after a movement of
/// the scene. Most of the sound may pass a narrow opening such as that of a door; few rays find it,
/// and no mean over frames is available yet. A choice: they find an opening with 1e-3 of what a
/// receiver sees by four rays.
inline constexpr int kMostGatherRays = 4096;

/// A pair of source and listener, as input to the plan of the gathers.
struct PairStatus {
    std::size_t source = 0;      ///< its emitter
    std::size_t listener = 0;    ///< its emitter
    int frames = 0;              ///< in its mean
    bool at_rest = false;        ///< its mean holds a window of frames, all since the last change
    bool source_starts = false;  ///< in this frame its source changes after a rest
};

/// The gathers of a frame.
struct GatherPlan {
    /// Weights of the caches of both ends in a pair's response.
    struct Shares {
        double source = 0;
        double listener = 0;
    };
    /// The gather at one receiver, which serves all emitters of the other end.
    struct Gather {
        std::vector<std::size_t> pairs;
        int rays = 0;  ///< most of a pair's
    };
    std::vector<Shares> shares;  ///< [pair]
    std::vector<Gather> at;      ///< [emitter] the receiver
};

/// Pairs to update in a frame: all but those at rest, of which a few are updated in turn.
std::vector<char> pairs_to_gather(std::span<const PairStatus> pairs, std::uint64_t frame);

/// Plans the gathers of the `wanted` pairs. `emitted`: rays in each emitter's cache. `rays`: those
/// of an emitter that moves, in a frame. `scene_moved`: within the last window of frames.
/// `emitters_in_motion`: those that move and emit, each of which has its own rays. The rays
/// of one receiver serve all emitters of the other end. Two gathers of M rays at both ends,
/// weighted by shares w and 1 - w that are also those of their rays, have the variance w^2 V / (w
/// M) + (1 - w)^2 V / ((1 - w) M) = V / M: as one gather of M rays. [propagation thread]
GatherPlan plan_gather(std::span<const PairStatus> pairs, std::span<const char> wanted,
                       std::span<const std::uint64_t> emitted, int rays, bool scene_moved,
                       std::size_t emitters_in_motion);

/// Number of gather rays of a receiver whose gathers are not averaged over frames.
int gather_rays_of_receiver(int rays, bool scene_moved);

}  // namespace aula
