#include "apps/room/frames/live_load.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <vector>

namespace aula {

namespace {

// Shares of the frame period.
constexpr double kTooMuch = 0.9;
constexpr double kWanted = 0.75;
constexpr double kRoom = 0.5;

// The median of this many frames is not affected by a frame that another program delayed. Of very
// long frames those of one second count.
constexpr std::size_t kFrames = 7;
constexpr double kEnoughTime_s = 1;

// Limits of one step: large downwards, small upwards.
constexpr double kFurthestDown = 0.1;
constexpr double kMinDown = 0.95;
constexpr double kUp = 1.2;
// Each change of the length requires preparation: fewer, larger steps.
constexpr double kLonger = 1.5;

constexpr double kFirstWait_s = 3;
constexpr double kLongestWait_s = 120;
/// If an increase is too much within this time, it came too early.
constexpr double kTrial_s = 5;

// Fewer rays cause noise, a shorter response lacks reverberation: the order and the limits of the
// reduction.
constexpr int kEnoughRays = 300;
constexpr double kEnoughLength_s = 1;
constexpr int kFewestRays = 100;
constexpr double kShortest_s = 0.3;

}  // namespace

LiveLoad::LiveLoad(const Full& full, int rays, double length_s)
    : full_(full),
      rays_(rays),
      length_s_(length_s),
      wait_s_(kFirstWait_s),
      since_increase_s_(kTrial_s) {}

void LiveLoad::change(const Full& full, int rays, double length_s) {
    full_ = full;
    rays_ = rays;
    length_s_ = length_s;
    quiet_s_ = 0;
    restart();
}

void LiveLoad::add(double took_s, double period_s, bool rays_fall) {
    recent_s_.push_back(took_s);
    if (recent_s_.size() > kFrames) recent_s_.pop_front();
    const double passed_s = std::max(took_s, period_s);
    since_increase_s_ += passed_s;
    const double measured_s = std::accumulate(recent_s_.begin(), recent_s_.end(), 0.0);
    if (recent_s_.size() < kFrames && measured_s < kEnoughTime_s) return;
    const double share = median_s() / period_s;
    quiet_s_ = share < kRoom ? quiet_s_ + passed_s : 0;
    if (share > kTooMuch)
        fall(std::clamp(kWanted / share, kFurthestDown, kMinDown), rays_fall);
    else if (quiet_s_ >= wait_s_)
        increase();
}

double LiveLoad::median_s() const {
    std::vector<double> sorted(recent_s_.begin(), recent_s_.end());
    const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
    std::nth_element(sorted.begin(), middle, sorted.end());
    return *middle;
}

void LiveLoad::fall(double factor, bool rays_fall) {
    const auto fewer_rays = [&](int min) {
        if (!full_.rays_fall || !rays_fall || rays_ <= min) return false;
        rays_ = std::max(min, static_cast<int>(std::lround(rays_ * factor)));
        return true;
    };
    const auto shorter = [&](double min_s) {
        if (!full_.length_falls || length_s_ <= min_s) return false;
        length_s_ = std::max(min_s, length_s_ * factor);
        return true;
    };
    if (!fewer_rays(kEnoughRays) && !shorter(kEnoughLength_s) && !fewer_rays(kFewestRays) &&
        !shorter(kShortest_s))
        return;
    if (since_increase_s_ < kTrial_s) wait_s_ = std::min(2 * wait_s_, kLongestWait_s);
    restart();
}

void LiveLoad::increase() {
    const bool longer = full_.length_falls && length_s_ < full_.length_s;
    if (longer && rays_ >= std::min(kEnoughRays, full_.rays))
        length_s_ = std::min(full_.length_s, length_s_ * kLonger);
    else if (rays_ < full_.rays)
        rays_ = std::min(full_.rays, static_cast<int>(std::ceil(rays_ * kUp)));
    else
        return;
    quiet_s_ = 0;
    since_increase_s_ = 0;
    restart();
}

}  // namespace aula
