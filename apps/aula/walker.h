#pragma once

#include "apps/aula/terminal.h"
#include "engine/scene/scene.h"

namespace aula {

/// A listener who walks by keys. A terminal only tells of presses, so each press is a short way to
/// go, walked at an even pace; a key held down repeats and keeps the walker going.
class Walker {
 public:
    explicit Walker(const Pose& start) : pose_(start) {}

    void press(Key key);

    /// Walks on for a time; returns where the listener is then.
    const Pose& advance(double time_s);

 private:
    Pose pose_;
    float ahead_m_ = 0;  ///< still to go, negative backwards
    float left_m_ = 0;
    float turn_rad_ = 0;
};

}  // namespace aula
