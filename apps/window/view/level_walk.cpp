#include "apps/window/view/level_walk.h"

#include <algorithm>
#include <glm/geometric.hpp>

#include "apps/output/formatted.h"
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
        for (const SoundPath& path : view.response.paths)
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

const LevelWalk::Point* LevelWalk::nearest(double walked_m) const {
    const auto after =
        std::lower_bound(points_.begin(), points_.end(), walked_m,
                         [](const Point& point, double at_m) { return point.walked_m < at_m; });
    if (after == points_.begin()) return points_.empty() ? nullptr : &points_.front();
    const auto before = after - 1;
    if (after == points_.end()) return &*before;
    return walked_m - before->walked_m <= after->walked_m - walked_m ? &*before : &*after;
}

std::string text_of(const LevelWalk::Point& point) {
    std::string text = fixed_text(point.walked_m, 2) + " m";
    for (std::size_t b = 0; b < kBandCount; ++b) {
        const auto level_db = static_cast<double>(point.level_db[b]);
        text += formatted("\n%5.0f Hz ", static_cast<double>(kBandCentres_hz[b])) +
                fixed_text(level_db, 1, 6) + " dB";
    }
    return text;
}

}  // namespace aula
