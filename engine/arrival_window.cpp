#include "engine/arrival_window.h"

#include <glm/geometric.hpp>

namespace aula {

void ArrivalWindow::add_frame(const Vec3& source, const Vec3& listener, double travel_m,
                              std::span<const Arrival> arrivals, int rays) {
    if (frames_.size() == window_frames_) frames_.pop_front();
    frames_.push_back({source, listener, travel_m, {arrivals.begin(), arrivals.end()}, rays});
    while (!still_holds(frames_.front())) frames_.pop_front();
}

bool ArrivalWindow::still_holds(const Frame& frame) const {
    const Frame& now = frames_.back();
    const double moved_m = double{glm::distance(frame.source, now.source)} +
                           double{glm::distance(frame.listener, now.listener)} + now.travel_m -
                           frame.travel_m;
    return moved_m <= double{reach_m_};
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
    for (const Frame& frame : frames_) arrivals += frame.arrivals.size();
    return arrivals * sizeof(Arrival);
}

}  // namespace aula
