#include "apps/room/frames/ray_load.h"

#include <algorithm>
#include <utility>

namespace aula {

RayLoad::RayLoad(ReportRays report) : report_(std::move(report)) {}

int RayLoad::next(int wanted, double took_s, double period_s) {
    // A slow machine needs some seconds to reach its number of rays.
    constexpr double kStableTime_s = 6;
    if (!load_ || load_->full().rays != wanted)
        load_.emplace(LiveLoad::Full{
            .rays = wanted, .length_s = 0, .rays_fall = true, .length_falls = false});
    else
        load_->add(took_s, period_s);
    const int rays = load_->rays();
    reduced_s_ = rays < wanted ? reduced_s_ + std::max(took_s, period_s) : 0;
    const bool is_stable = reduced_s_ >= kStableTime_s;
    if (reported_ ? reduced_s_ == 0 : is_stable) {
        reported_ = is_stable;
        report_(rays, wanted);
    }
    return rays;
}

}  // namespace aula
