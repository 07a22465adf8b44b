#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "engine/base/worker_pool.h"
#include "engine/rays/ray_scene.h"
#include "engine/waves/dense_eigen.h"
#include "engine/waves/room_modes.h"
#include "engine/waves/wave_grid.h"

namespace aula {

/// The damping of a room's modes by each material: the integral of the product of two modes over
/// the walls of the material, in 1/m. It depends on the geometry alone.
class WallDamping {
 public:
    WallDamping(const WaveGrid& grid, const RoomModes& modes, WorkerPool& pool);

    /// The sum over the materials, each times the admittance that its absorption in an octave band
    /// needs. Openings have the admittance of air, 1.
    DenseMatrix damping(const RayScene& scene, std::size_t band) const;

    /// True if the materials absorb the same in both bands.
    bool is_equal(const RayScene& scene, std::size_t band, std::size_t other) const;

 private:
    std::size_t modes_;
    std::map<std::uint32_t, DenseMatrix> of_;
};

/// Octaves in which the field of an octave band is faded to that of the next one. Wider, strong
/// modes at an edge would be missing in their band; a step would ring.
inline constexpr double kOctaveFade = 1.0 / 48;

/// Share of the highest wave number of the modes over which their amplitudes in the field fall to
/// 0, linearly. Without it each further mode would change the field between the modes. A choice:
/// rays have nine tenths of the power above its beginning.
inline constexpr double kModeTaper = 0.15;

/// All poles of a room in 1/m, s = j k, with its walls as they are in some adjacent octaves.
struct OctavePoles {
    double begin = 0;  ///< 1/m; the middle of the fade to the octaves below; 0 for the lowest
    double end = 0;    ///< 1/m; the same above; infinity for the highest
    std::vector<DampedPole> poles;
};

/// The poles of a room with the absorption coefficients of each octave that has modes; octaves with
/// equal coefficients share them. Their residues have the taper.
std::vector<OctavePoles> room_poles(const RoomModes& modes, const WallDamping& damping,
                                    const RayScene& scene, double speed_of_sound_m_s,
                                    WorkerPool& pool);

}  // namespace aula
