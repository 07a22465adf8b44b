#pragma once

#include "engine/propagation.h"

namespace aula {

/// The number of rays with which the next frame takes a share of its time: the last frame's rays,
/// a little more or less, by what its rays and everything else took. Unchanged where the last frame
/// traced none.
int rays_within_budget(int rays, const FrameStatistics& last, double last_frame_s,
                       double allowed_s);

}  // namespace aula
