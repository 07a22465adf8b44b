#include "apps/room/frames/ray_budget.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "apps/output/formatted.h"

namespace aula {

namespace {

/// Of all sources together. The gather of a source then takes most of the time, so that fewer rays
/// save little.
constexpr int kFewest = 100;

/// Of one source. Its gather of 128 rays, the fewest, then takes most of the time.
constexpr int kFewestOfSource = 25;

// Times of one core of a 2.3 GHz Xeon (`aula-bench budget`). A segment takes from 80 ns in a box to
// 250 ns in a mesh of 139,000 triangles, a reflection of an image source from 20 ns to 270 ns.
constexpr double kSegment_s = 170e-9;     ///< to trace a segment and to store what it deposits
constexpr double kBin_s = 6e-9;           ///< to add a time bin of a patch in the final gather
constexpr double kReflection_s = 130e-9;  ///< to examine one of an image source and to trace it

/// Of two processors in normal quality, half of one renders the sound of the frames.
constexpr double kProcessors = 1.5;

/// The time of a quality relative to that of Quality::normal.
double share_of(Quality quality) {
    switch (quality) {
        case Quality::draft:
            return 0.25;
        case Quality::normal:
            return 1;
        case Quality::fine:
            break;
    }
    return std::numeric_limits<double>::infinity();
}

}  // namespace

double counted_s(const FrameStatistics& statistics) {
    return kSegment_s * static_cast<double>(statistics.segments) +
           kBin_s * static_cast<double>(statistics.summed_bins) +
           kReflection_s * static_cast<double>(statistics.image_reflections);
}

double allowed_s(Quality quality, double frame_period_s) {
    return frame_period_s * kProcessors * share_of(quality);
}

std::string over_budget_text(const Simulation& simulation, std::size_t sources, int rays,
                             double counted_frame_s) {
    // The first frames of a rendering have more rays than the later ones.
    constexpr double kClearly = 1.5;
    const double period_s = 1 / double{simulation.frame_rate_hz};
    const int fewest = fewest_rays(sources);
    if (simulation.rays || rays > fewest ||
        counted_frame_s < kClearly * allowed_s(simulation.quality, period_s))
        return "";
    return formatted(
        "a second of sound takes about %.1f s of two processors with %zu %s and %d "
        "rays, the fewest; fewer moving sources, a shorter --ir-length, "
        "\"transmission\": false or a lower --frame-rate reduce it",
        counted_frame_s / (kProcessors * period_s), sources, sources == 1 ? "source" : "sources",
        fewest);
}

int fewest_rays(std::size_t sources) {
    const auto count = static_cast<int>(std::clamp<std::size_t>(sources, 1, kFewest));
    return std::max(kFewest / count, kFewestOfSource);
}

int live_rays(const Simulation& simulation) {
    const double share = std::min(1.0, share_of(simulation.quality));
    return simulation.rays.value_or(static_cast<int>(std::lround(share * Simulation::kRays)));
}

int rays_within_work(int rays, const FrameStatistics& last, double allowed_s, std::size_t sources) {
    // Slowly upwards: the work of a frame also depends on what moves in it.
    constexpr double kMaxUp = 1.1;
    const double wanted = rays * std::min(kMaxUp, allowed_s / counted_s(last));
    return static_cast<int>(
        std::lround(std::clamp<double>(wanted, fewest_rays(sources), Simulation::kRays)));
}

int rays_within_budget(int rays, const FrameStatistics& last, double last_frame_s, double allowed_s,
                       std::size_t sources) {
    constexpr int kMax = 20'000;
    // A frame that traced nothing gives no estimate of the time per ray.
    constexpr double kNegligible_s = 1e-4;
    // Times are noisy: limited steps per frame, larger downwards than upwards.
    constexpr double kMaxUp = 1.1;
    constexpr double kMaxDown = 0.7;
    if (last.trace_s < kNegligible_s) return rays;
    const double per_ray_s = (last.trace_s + last.cache_s) / rays;
    const double others_s = std::max(0.0, last_frame_s - last.trace_s - last.cache_s);
    const double wanted = std::max(0.0, allowed_s - others_s) / per_ray_s;
    const double step = std::clamp(wanted / rays, kMaxDown, kMaxUp);
    return std::clamp(static_cast<int>(std::lround(rays * step)), fewest_rays(sources), kMax);
}

}  // namespace aula
