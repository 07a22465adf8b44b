#pragma once

#include <vector>

#include "aula/engine/frame.h"
#include "engine/rays/ray_scene.h"

namespace aula {

class Propagation;

/// The rays of a frame, for benchmarks, which trace them by other code.
class FrameRays {
 public:
    /// Those that the next step() will emit if nothing in the scene moves: those of the paths in
    /// their order, then those of the final gather.
    static std::vector<Ray> of_next(const Propagation& propagation, const FrameInput& input);
};

}  // namespace aula
