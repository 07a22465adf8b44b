#include "engine/arrival_window.h"

#include <glm/geometric.hpp>

namespace aula {

void ArrivalWindow::advance(const State& now) {
    now_ = now;
    while (!frames_.empty() && !holds(frames_.front())) frames_.pop_front();
}

double ArrivalWindow::moved_m(const Frame& frame) const {
    const State& then = frame.state;
    return double{glm::distance(then.source, now_.source)} +
           double{glm::distance(then.listener, now_.listener)} + now_.travel_m - then.travel_m;
}

bool ArrivalWindow::holds(const Frame& frame) const {
    const double moved = moved_m(frame);
    return moved == 0 ||
           (moved <= double{reach_m_} && now_.frame - frame.state.frame < window_frames_);
}

bool ArrivalWindow::settled() const { return frames_.empty() || moved_m(frames_.front()) == 0; }

void ArrivalWindow::add(std::span<const Arrival> arrivals, int rays) {
    if (frames_.empty() || frames_.back().state.frame != now_.frame) {
        if (frames_.size() == window_frames_) frames_.pop_front();
        frames_.push_back({now_, {}, 0});
    }
    Frame& frame = frames_.back();
    frame.arrivals.insert(frame.arrivals.end(), arrivals.begin(), arrivals.end());
    frame.rays += rays;
    while (frames_.size() > 1 && memory_bytes() > memory_bytes_) frames_.pop_front();
}

void ArrivalWindow::add_to(EnergyResponse& response) const {
    double emitted = 0;
    for (const Frame& frame : frames_) emitted += frame.rays;
    if (emitted == 0) return;
    const auto scale = static_cast<float>(1 / emitted);
    for (const Frame& frame : frames_) {
        for (const Arrival& arrival : frame.arrivals) {
            const std::size_t bin =
                response.bins.index(double{arrival.length_m} / double{response.speed_of_sound_m_s});
            if (bin >= response.bins.count()) continue;
            const Bands energy = arrival.energy * scale;
            response.energy[bin] += energy;
            response.direction[bin] += energy.sum() * arrival.direction;
        }
    }
}

std::size_t ArrivalWindow::memory_bytes() const {
    std::size_t arrivals = 0;
    for (const Frame& frame : frames_) arrivals += frame.arrivals.capacity();
    return arrivals * sizeof(Arrival);
}

}  // namespace aula
