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

}  // namespace aula
