#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "aula/engine/vec3.h"

namespace aula {

/// The sound of a diffuse field at several points: white noises of unit variance with the coherence
/// sin(kd) / (kd) between points at the distance d, k = 2 pi f / c (Cook et al. 1955). Independent
/// noises are mixed at each frequency by a Cholesky factor of the matrix of coherences (Habets et
/// al. 2008). Immutable.
class DiffuseNoise {
 public:
    static constexpr std::size_t kMaxPoints = 128;

    /// At most kMaxPoints points. `samples` >= 2 is the least length of the noises; they are
    /// periodic. The noise of the first point does not depend on the others.
    DiffuseNoise(std::span<const Vec3> points, std::size_t samples, double sample_rate_hz,
                 double speed_of_sound_m_s, std::uint64_t seed);

    /// The period of the noise of a point.
    const std::vector<float>& at(std::size_t point) const { return noises_[point]; }

 private:
    std::vector<std::vector<float>> noises_;  ///< [point]
};

}  // namespace aula
