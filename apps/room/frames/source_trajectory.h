#pragma once

#include <deque>

#include "aula/engine/energy_response.h"
#include "aula/engine/vec3.h"

namespace aula {

/// The last positions of a source. What is heard at the time t left the source at t - d, where it
/// was then: the delay solves d = r(t - d) / c, with the length r of the path from that position
/// (Pierce, Acoustics: retarded time). [propagation thread]
class SourceTrajectory {
 public:
    /// `longest_s`: the longest delay that is asked for.
    explicit SourceTrajectory(double longest_s) : longest_s_(longest_s) {}

    /// Adds the position at a time that is not earlier than the last one. A jump, faster than half
    /// the speed of sound, or an earlier time begins a new trajectory: before it the source stood
    /// still.
    void add(double time_s, const Vec3& position, double speed_of_sound_m_s);

    /// Delay of a path that the newest position has, in s. That of a static source is its length
    /// over the speed of sound.
    double delay_s(const SoundPath& path, double speed_of_sound_m_s) const;

 private:
    struct Place {
        double time_s;
        glm::dvec3 position;
    };

    glm::dvec3 position_at(double time_s) const;

    double longest_s_;
    std::deque<Place> places_;
};

}  // namespace aula
