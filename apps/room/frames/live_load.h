#pragma once

#include <deque>

namespace aula {

/// Reduces the rays and the response length of live playback until frames are computed within their
/// period. Between half and nine tenths of the period nothing changes. Length and rays increase
/// again after a time with room, which doubles whenever the increase was too large.
/// [propagation thread]
class LiveLoad {
 public:
    /// Rays and length of a scene, and which of them are not given and may be reduced.
    struct Full {
        int rays = 0;
        double length_s = 0;
        bool rays_fall = false;
        bool length_falls = false;
    };

    /// Begins with these rays and this length.
    LiveLoad(const Full& full, int rays, double length_s);
    explicit LiveLoad(const Full& full) : LiveLoad(full, full.rays, full.length_s) {}

    /// Adds the computation time of a frame and its period. `rays_fall`: the frame had rays() rays.
    void add(double took_s, double period_s, bool rays_fall = true);

    /// Restarts the measurement after a change of the playback.
    void restart() { recent_s_.clear(); }

    /// Continues with other values, with the waits for increases so far.
    void change(const Full& full, int rays, double length_s);

    int rays() const { return rays_; }
    double length_s() const { return length_s_; }
    const Full& full() const { return full_; }

 private:
    double median_s() const;
    void fall(double factor, bool rays_fall);
    void increase();

    Full full_;
    int rays_;
    double length_s_;
    std::deque<double> recent_s_;
    double quiet_s_ = 0;  ///< time for which there has been room
    double wait_s_;       ///< time for which there must be room before an increase
    double since_increase_s_;
};

}  // namespace aula
