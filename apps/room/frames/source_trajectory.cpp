#include "apps/room/frames/source_trajectory.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace aula {

namespace {

// Re the speed of sound. The renderer crossfades where a path changes faster.
constexpr double kFastestMove = 0.5;

// Each iteration reduces the error by the speed of the source over that of sound, at most 1/2; a
// nanosecond is 2e-5 samples at 20 kHz.
constexpr int kMostIterations = 32;
constexpr double kSolved_s = 1e-9;

}  // namespace

void SourceTrajectory::add(double time_s, const Vec3& position, double speed_of_sound_m_s) {
    const glm::dvec3 there(position);
    if (!places_.empty()) {
        const Place& last = places_.back();
        const double passed_s = time_s - last.time_s;
        const double moved_m = glm::distance(there, last.position);
        if (passed_s < 0 || moved_m > kFastestMove * speed_of_sound_m_s * passed_s) {
            places_.clear();
        } else if (places_.size() > 1 && moved_m == 0 &&
                   places_[places_.size() - 2].position == there) {
            // Two places are enough where the source stands.
            places_.pop_back();
        }
    }
    places_.push_back({time_s, there});
    while (places_.size() > 2 && places_[1].time_s < time_s - longest_s_) places_.pop_front();
}

glm::dvec3 SourceTrajectory::position_at(double time_s) const {
    const auto after =
        std::upper_bound(places_.begin(), places_.end(), time_s,
                         [](double t, const Place& place) { return t < place.time_s; });
    if (after == places_.begin()) return after->position;
    if (after == places_.end()) return places_.back().position;
    const Place& before = *std::prev(after);
    const double share = (time_s - before.time_s) / (after->time_s - before.time_s);
    return before.position + share * (after->position - before.position);
}

// By the image of the listener, seen from the source in the direction of departure at the path's
// length: its distance from any other position of the source is the length of the path from there,
// as long as the path keeps its walls. A path that bends around edges has its first edge in place
// of the image; the way from there to the listener does not change.
double SourceTrajectory::delay_s(const SoundPath& path, double speed_of_sound_m_s) const {
    const double length_m{path.length_m};
    const double static_s = length_m / speed_of_sound_m_s;
    const double departure = glm::length(glm::dvec3(path.departure));
    if (places_.size() < 2 || departure == 0) return static_s;
    const Place& now = places_.back();
    const bool bends_first = path.order == 0 && !path.apexes.empty();
    const glm::dvec3 image =
        bends_first ? glm::dvec3(path.apexes.front())
                    : now.position + glm::dvec3(path.departure) * (length_m / departure);
    const double now_m = glm::distance(now.position, image);
    double delay_s = static_s;
    for (int i = 0; i < kMostIterations; ++i) {
        const double then_m = glm::distance(position_at(now.time_s - delay_s), image);
        const double next_s = static_s + (then_m - now_m) / speed_of_sound_m_s;
        const bool solved = std::abs(next_s - delay_s) < kSolved_s;
        delay_s = next_s;
        if (solved) break;
    }
    return delay_s;
}

}  // namespace aula
