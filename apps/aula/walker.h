#pragma once

#include "apps/aula/terminal/key_input.h"
#include "aula/engine/scene.h"

namespace aula {

/// Listener movement by terminal keys. A terminal reports key presses only, not releases: each
/// press adds a short distance or angle, covered at constant speed, and the repeats of a held key
/// sustain the movement.
class Walker {
 public:
    explicit Walker(const Pose& start) : pose_(start) {}

    void press(Key key);

    /// Moves for `time_s` seconds; returns the new pose.
    const Pose& advance(double time_s);

 private:
    Pose pose_;
    float ahead_m_ = 0;  ///< remaining, negative backwards
    float left_m_ = 0;
    float turn_rad_ = 0;
};

}  // namespace aula
