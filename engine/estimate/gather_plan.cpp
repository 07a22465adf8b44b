#include "engine/estimate/gather_plan.h"

#include <algorithm>
#include <cmath>

#include "engine/estimate/final_gather.h"

namespace aula {

namespace {

/// Gather rays of a pair at rest, per ray of its ends.
constexpr double kShareAtRest = 0.75;

/// The same in motion, per ray of an emitter: the rays of an end at rest accumulate in its cells,
/// the gathers at the moving end do not. At equal time the error of walks is least for 1 in the
/// shoebox and in two rooms and for 2 in the museum, at 1000 rays.
constexpr double kShareInMotion = 1.5;

/// The same in the first frame of a movement of the source, which costs most: the sums of the
/// listener, whose rays are then gathered, are not in the processor's caches.
constexpr double kShareAtStart = 1;

/// With few rays the gather has most of the noise of a single frame, above all between mirrors. The
/// fewest are those for 512 rays of an emitter, a choice.
constexpr int kFewestInMotion = 768;
constexpr int kFewestAtStart = 512;  // the same for kShareAtStart
static_assert(kFewestInMotion == kShareInMotion * 512 && kFewestAtStart == kShareAtStart * 512);

/// With still fewer rays those of the emitters have most of it, and the time of the gather counts:
/// a choice that begins at 192 rays, so that 300, enough for live playback, keep the fewest of one
/// pair.
constexpr int kMostPerRay = 4;

/// At a receiver whose gathers are not averaged over frames. A choice: its own noise, in bins of 10
/// ms, is that of 1000 rays of a source.
constexpr int kFewestAtReceiver = 1024;

/// Numbers of gather rays are multiples of a batch.
constexpr int kStep = FinalGather::kBatchRays;
static_assert(kMostGatherRays % kStep == 0);

/// An end with less than this share of the rays is ignored, which saves its gather. The error of
/// the other one alone is 5 % larger at most: 1 / sqrt(1 - kMinShare).
constexpr double kMinShare = 0.1;

/// Number of pairs at rest that are gathered again in a frame, in turn. A choice: the frames of
/// many pairs at rest cost little, and the response of each of sixteen gets a new gather four times
/// a second.
constexpr std::size_t kPairsAtRestPerFrame = 2;

/// Number of rays of a gather in motion, `share` per ray of an emitter.
double rays_in_motion(int rays, bool scene_moved, double share, int fewest) {
    if (scene_moved) return kMostGatherRays;
    const int lowest = std::min(fewest, kMostPerRay * rays);
    return std::clamp(share * rays, double(lowest), double{kMostGatherRays});
}

/// What gathers in motion have of their rays where the rays of an emitter serve `pairs` of them.
/// The n pairs sum the hits of M rays each, at one receiver or at several, for the cost n b M: with
/// the cost a R of the emitter's rays the best number is R sqrt(a B / (n b A)). See rays_of_pair().
double share_of_each(double pairs) { return 1 / std::sqrt(std::max(pairs, 1.0)); }

/// Number of rays with which a pair gathers. The variance of a pair's mean is A / R + B / M after R
/// rays of its ends and M gather rays. With the costs a and b of a ray it is least, at a given
/// time, for M = R sqrt(a B / (b A)). At equal costs kShareAtRest makes it at most 10 % higher for
/// B from A / 7 to A. Until the mean holds a whole window it has fewer frames than the caches, and
/// most of the noise is that of the frame's own gather.
double rays_of_pair(const PairStatus& pair, std::uint64_t emitted, int rays, bool scene_moved,
                    double pairs_of_emitter) {
    if (pair.source_starts)
        return share_of_each(pairs_of_emitter) *
               rays_in_motion(rays, scene_moved, kShareAtStart, kFewestAtStart);
    const double in_motion = rays_in_motion(rays, scene_moved, kShareInMotion, kFewestInMotion);
    if (!pair.at_rest) return share_of_each(pairs_of_emitter) * in_motion;
    const double of_a_frame = kShareAtRest * static_cast<double>(emitted) / (pair.frames + 1);
    return std::max(double{kStep}, std::min(of_a_frame, in_motion));
}

}  // namespace

std::vector<char> pairs_to_gather(std::span<const PairStatus> pairs, std::uint64_t frame) {
    const std::size_t count = pairs.size();
    if (count == 0) return {};
    const std::size_t turn = frame * kPairsAtRestPerFrame % count;
    std::vector<char> wanted(count, 0);
    for (std::size_t i = 0; i < count; ++i) {
        wanted[i] = !pairs[i].at_rest || (i + count - turn) % count < kPairsAtRestPerFrame;
    }
    return wanted;
}

GatherPlan plan_gather(std::span<const PairStatus> pairs, std::span<const char> wanted,
                       std::span<const std::uint64_t> emitted, int rays, bool scene_moved,
                       std::size_t emitters_in_motion) {
    GatherPlan plan;
    plan.shares.resize(pairs.size());
    plan.at.resize(emitted.size());
    std::size_t in_motion = 0;
    for (std::size_t i = 0; i < pairs.size(); ++i)
        if (wanted[i] && !pairs[i].at_rest) ++in_motion;
    // Emitters at rest share one budget of rays.
    const double pairs_of_emitter =
        static_cast<double>(in_motion) /
        static_cast<double>(std::max<std::size_t>(emitters_in_motion, 1));
    for (std::size_t i = 0; i < pairs.size(); ++i) {
        if (!wanted[i]) continue;
        const PairStatus& pair = pairs[i];
        const std::uint64_t all = emitted[pair.source] + emitted[pair.listener];
        if (all == 0) continue;
        double share = static_cast<double>(emitted[pair.source]) / static_cast<double>(all);
        if (share < kMinShare) share = 0;
        if (share > 1 - kMinShare) share = 1;
        plan.shares[i] = {share, 1 - share};
        // The ends divide the M rays of a pair by the weights w and 1 - w of their estimates. With
        // the variance V of one ray, w^2 V / (w M) + (1 - w)^2 V / ((1 - w) M) = V / M: variance
        // and cost are those of one gather.
        const double of_pair = rays_of_pair(pair, all, rays, scene_moved, pairs_of_emitter);
        const auto gather_at = [&](std::size_t receiver, double part) {
            if (part == 0) return;
            GatherPlan::Gather& gather = plan.at[receiver];
            gather.pairs.push_back(i);
            const double steps = std::ceil(part * of_pair / kStep);
            gather.rays = std::max(gather.rays, static_cast<int>(steps) * kStep);
        };
        gather_at(pair.listener, share);
        gather_at(pair.source, 1 - share);
    }
    return plan;
}

int gather_rays_of_receiver(int rays, bool scene_moved) {
    return static_cast<int>(rays_in_motion(rays, scene_moved, kShareInMotion, kFewestAtReceiver));
}

}  // namespace aula
