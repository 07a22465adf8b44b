#include "engine/leg_window.h"

#include "engine/transmission.h"

namespace aula {

void LegWindow::advance(const State& now) {
    if (now.changed_since(now_)) crowded_ = false;
    now_ = now;
    while (!frames_.empty() && !holds(frames_.front())) forget_oldest();
}

bool LegWindow::holds(const Frame& frame) const {
    const double moved_m = now_.moved_m(frame.state);
    return moved_m == 0 ||
           (moved_m <= double{reach_m_} && now_.frame - frame.state.frame < window_frames_);
}

void LegWindow::forget_oldest() {
    legs_ -= frames_.front().legs.size();
    rays_ -= frames_.front().rays;
    frames_.pop_front();
}

void LegWindow::add(std::span<const TraceBatch> batches, int rays) {
    Frame frame{now_, static_cast<std::uint64_t>(rays), {}, {}};
    for (const TraceBatch& batch : batches) {
        frame.legs.insert(frame.legs.end(), batch.legs.begin(), batch.legs.end());
        frame.sounds.insert(frame.sounds.end(), batch.leg_sounds.begin(), batch.leg_sounds.end());
    }
    legs_ += frame.legs.size();
    rays_ += frame.rays;
    frames_.push_back(std::move(frame));
    while (frames_.size() > 1 && ((legs_ > most_legs_ && frames_.size() > window_frames_) ||
                                  memory_bytes() > memory_bytes_)) {
        forget_oldest();
        crowded_ = true;
    }
}

bool LegWindow::settled() const {
    return frames_.empty() || now_.moved_m(frames_.front().state) == 0;
}

void LegWindow::add_to(const RayScene& scene, const Receiver& receiver, double scale,
                       EnergyResponse& response) const {
    const double speed_m_s{response.speed_of_sound_m_s};
    for (const Frame& frame : frames_) {
        for (std::size_t i = 0; i < frame.legs.size(); ++i) {
            const Leg& leg = frame.legs[i];
            const auto chord = receiver.chord(scene, leg.origin, leg.direction, leg.length_m);
            if (!chord) continue;
            const std::size_t bin =
                response.bins.index(double{leg.before_m + chord->middle_m} / speed_m_s);
            if (bin >= response.bins.count()) continue;
            const LegSound& sound = frame.sounds[i];
            const Bands energy = sound.energy * transmission(attenuation_per_m_, chord->middle_m) *
                                 (chord->share_1_m2 * static_cast<float>(scale));
            response.energy[bin] += energy;
            response.direction[bin] += energy.sum() * sound.from;
        }
    }
}

std::size_t LegWindow::memory_bytes() const { return legs_ * (sizeof(Leg) + sizeof(LegSound)); }

}  // namespace aula
