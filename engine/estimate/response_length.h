#pragma once

#include <cstdint>
#include <span>

#include "aula/engine/medium.h"
#include "engine/base/worker_pool.h"
#include "engine/rays/ray_scene.h"

namespace aula {

/// The time in s from the emission on in which the response from every source position to every
/// listener position decays by 70 dB in each octave band, at most `longest_s`: the default length
/// of the responses. At least the travel time of the direct sound, and 0.3 s.
///
/// Sound particles leave each source position. Their energy near a listener position that sees them
/// is, up to a factor, the energy response of the pair without its direct sound. It is followed
/// until its backward integral has fallen by 70 dB in every band, or until its slope shows that it
/// will not within `longest_s`; so is the whole energy, also that of particles from the listener
/// positions, since responses are reciprocal. Of many positions at most eight, far from each other,
/// represent all.
///
/// Sources are omnidirectional. Movable objects are at their present positions. `order` limits the
/// reflections; 0: no limit.
double sounding_length_s(const RayScene& scene, const Medium& medium, int order,
                         std::span<const Vec3> sources, std::span<const Vec3> listeners,
                         double longest_s, std::uint64_t seed, WorkerPool& workers);

}  // namespace aula
