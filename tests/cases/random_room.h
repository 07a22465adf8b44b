#pragma once

#include <cstdint>

#include "aula/engine/scene.h"

namespace aula::test {

/// A random closed room with an impulse at a source and a listener at rest, without a length of the
/// responses: by seed % 4 a box, two boxes coupled by an opening, a hall with an absorbing ceiling
/// or floor, or a prism over a random polygon with a pillar. The materials differ from wall to wall
/// and from octave to octave.
Scene random_room(std::uint64_t seed);

}  // namespace aula::test
