#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "aula/engine/bands.h"

namespace aula {

/// Limits a population of paths without bias: systematic resampling, as in particle filters. Chosen
/// paths are strengthened, so that the mean energy of every path is unchanged in every band. Of
/// paths with equal spectra the sum of the energies of each generation is unchanged as well.
///
/// A path is chosen in proportion to sum_b E_b / T_b, where T_b is the total energy of its
/// generation in band b: no band starves. Each generation has some places, and the rest are shared
/// in proportion to the sum of its shares of the energies of the bands: no generation starves. A
/// generation is the number of walls that its paths have passed; from three on they are one.
class Resampler {
 public:
    /// A chosen path, and the factor for its energy.
    struct Survivor {
        std::size_t index = 0;
        float factor = 1;
    };

    /// Chooses at most `places` >= 3 paths, by ascending index; a strong path may be chosen several
    /// times. All if there are no more. Valid until the next call.
    std::span<const Survivor> choose(std::span<const Bands> energies,
                                     std::span<const std::uint32_t> walls_passed,
                                     std::size_t places, std::uint64_t seed);

 private:
    std::vector<float> importance_;
    std::vector<Survivor> survivors_;
};

/// The number of paths behind walls as their energy falls. From -30 dB of the highest energy on it
/// falls with the square root of the energy, to kFewest. Then all paths together survive a
/// reflection with the square root of the share of energy that it leaves: the roulette of single
/// paths cannot end them where each hit adds a path, as in the gap of a door.
class Thinning {
 public:
    /// A choice: beside the 64 to kLanes paths of a batch, walls take less time than the room.
    static constexpr std::size_t kMost = 32;
    /// One for each of the places that resampling reserves.
    static constexpr std::size_t kFewest = 6;

    /// Sets the number of places for paths of that total energy. Returns the factor of their
    /// energies if they survive, which `u`, uniform in 0..1, decides; else 0. Paths
    /// without energy do not.
    float next(double energy, double u);

    std::size_t places() const { return places_; }

 private:
    double highest_energy_ = 0;
    double survival_ = 1;  ///< of all paths so far
    std::size_t places_ = kMost;
};

}  // namespace aula
