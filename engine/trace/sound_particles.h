#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/base/sampling.h"
#include "engine/base/worker_pool.h"
#include "engine/rays/ray_scene.h"
#include "engine/rays/wall_crossing.h"

namespace aula {

/// A packet of sound energy that travels at the speed of sound. Its energy is that without the
/// losses of the air, which are the same for all particles of one age.
struct SoundParticle {
    Ray segment{Vec3(0), Vec3(0)};
    Hit hit{};              ///< the end of the segment; none: the particle escapes
    float travelled_m = 0;  ///< on the segment
    int reflections = 0;
    Bands energy;  ///< 0 after an escape or the last reflection
    RandomStream random{};

    Vec3 position() const { return segment.origin + travelled_m * segment.direction; }
};

/// A population of sound particles from one point, observed at equal times (sound particle method,
/// Stephenson 1990). Reflections and passages through walls obey the laws of the path tracer. A
/// population of constant size replaces roulette: choose() repeats important particles and drops
/// others ("go with the winners", Aldous and Vazirani 1994), so that the statistical error does not
/// grow while the energy falls. The results are the same for any number of threads.
class SoundParticles {
 public:
    /// `order` limits the reflections; 0: no limit.
    SoundParticles(const RayScene& scene, int order, const Vec3& start, std::size_t count,
                   std::uint64_t seed);

    /// Moves all particles on by a distance.
    void advance(float distance_m, WorkerPool& workers);

    /// Replaces the population by systematic resampling in proportion to `importance`, [particle],
    /// whose sum is above 0. The mean energy of each particle remains. Does nothing while the
    /// importance is spread over enough particles.
    void choose(std::span<const double> importance);

    const std::vector<SoundParticle>& all() const { return particles_; }

 private:
    void advance(std::span<SoundParticle> block, float distance_m) const;
    void reflect(SoundParticle& particle, std::vector<WallExit>& exits) const;

    const RayScene& scene_;
    int order_;
    std::uint64_t seed_;
    std::uint64_t choices_ = 0;
    std::vector<SoundParticle> particles_;
};

}  // namespace aula
