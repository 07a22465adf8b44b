#include "apps/session/frames/ray_budget.h"

#include <algorithm>
#include <cmath>

namespace aula {

int rays_within_budget(int rays, const FrameStatistics& last, double last_frame_s,
                       double allowed_s) {
    constexpr int kFewest = 100;
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
    return std::clamp(static_cast<int>(std::lround(rays * step)), kFewest, kMax);
}

}  // namespace aula
