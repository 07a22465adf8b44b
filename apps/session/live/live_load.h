#pragma once

#include <deque>

namespace aula {

/// Lowers the rays and the response's length of what plays live until its frames are computed in
/// their time. Between half of a frame's time and nine tenths of it nothing changes. Rays come back
/// where there is room for long, after ever longer waits if that was too many; the length does not,
/// as each change of it is prepared anew. [propagation thread]
class LiveLoad {
 public:
    /// What a scene would have, and what of it is not given and may fall.
    struct Full {
        int rays = 0;
        double length_s = 0;
        bool rays_fall = false;
        bool length_falls = false;
    };

    /// Begins with so many rays and such a length.
    LiveLoad(const Full& full, int rays, double length_s);
    explicit LiveLoad(const Full& full) : LiveLoad(full, full.rays, full.length_s) {}

    /// Takes in what a frame took of its period. `rays_fall`: its rays were rays().
    void add(double took_s, double period_s, bool rays_fall = true);

    /// Begins to measure anew: what was measured is not of what plays now.
    void restart() { recent_s_.clear(); }

    int rays() const { return rays_; }
    double length_s() const { return length_s_; }
    const Full& full() const { return full_; }

 private:
    double median_s() const;
    void fall(double factor, bool rays_fall);
    void rise();

    Full full_;
    int rays_;
    double length_s_;
    std::deque<double> recent_s_;
    double quiet_s_ = 0;   ///< for how long there was room
    double wait_s_;        ///< for how long there has to be before rays come back
    double since_rise_s_;  ///< since they last did
};

}  // namespace aula
