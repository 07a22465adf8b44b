#include "apps/window/view/level_walk.h"

#include <glm/geometric.hpp>

#include "apps/window/view/curves.h"

namespace aula {

namespace {

constexpr float kLeastStep_m = 0.005F;
constexpr float kJump_m = 2;

}  // namespace

void LevelWalk::add(const FrameView& view) {
    if (!points_.empty() && view.frame == frame_) return;
    frame_ = view.frame;
    Point point;
    for (std::size_t band = 0; band < kBandCount; ++band) {
        double energy = 0;
        for (const SpecularPath& path : view.response.paths)
            if (path.order == 0) energy += static_cast<double>(path.energy[band]);
        point.level_db[band] = energy_db(squared_pressure(energy));
    }
    const Vec3& here = view.listener.position;
    const float step_m = glm::distance(here, listener_);
    if (points_.empty() || view.source != source_ || step_m > kJump_m) {
        points_.clear();
        source_ = view.source;
        listener_ = here;
    } else if (step_m < kLeastStep_m) {
        point.walked_m = points_.back().walked_m;
        points_.pop_back();
    } else {
        point.walked_m = points_.back().walked_m + double{step_m};
        listener_ = here;
    }
    points_.push_back(point);
    while (points_.front().walked_m < point.walked_m - kLength_m) points_.pop_front();
}

}  // namespace aula
