#pragma once

#include "aula/engine/propagation.h"

namespace aula {

/// The number of rays with which the next frame takes `allowed_s`: the last frame's rays, changed
/// in a limited step according to the times of its rays and of its other parts. Unchanged if the
/// last frame traced none.
int rays_within_budget(int rays, const FrameStatistics& last, double last_frame_s,
                       double allowed_s);

}  // namespace aula
