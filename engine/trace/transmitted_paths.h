#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "engine/rays/wall_crossing.h"
#include "engine/trace/path_batch.h"
#include "engine/trace/resampling.h"

namespace aula {

/// The paths behind walls of a batch of rays. At every hit on a wall that transmits, a path emerges
/// on the far side with the transmitted energy; the one that hits is reflected as at an opaque
/// wall. Transmitted shares of 1e-1 to 1e-6 make both alternatives to this useless: roulette would
/// hardly ever transmit, and the number of paths would grow without limit. The number of paths
/// behind walls is therefore limited to kPlaces by unbiased resampling after each reflection. Once
/// transmitted, they are ordinary paths. [several threads]
class TransmittedPaths {
 public:
    /// Largest number of paths of a batch of up to kLanes rays. From -30 dB of the highest energy
    /// behind walls on it falls with the square root of the energy, to kFewestPlaces. Then all
    /// paths together survive a reflection with the square root of the share of energy that it
    /// leaves: the roulette of single paths cannot end them where each hit adds a path, as in the
    /// gap of a door.
    static constexpr std::size_t kPlaces = 32;
    static constexpr std::size_t kFewestPlaces = 6;

    TransmittedPaths(const RayScene& scene, const Bands& attenuation_per_m, float max_length_m,
                     std::uint64_t seed);

    /// The paths behind walls, which PathTracer reflects as it does those of the rays.
    PathBatch& paths() { return *paths_; }

    /// Finds the paths that emerge from walls at the present hits of `from`, after
    /// PathBatch::arrive and before PathBatch::scatter. `reflections` precede these hits.
    void transmit(const PathBatch& from, int reflections);

    /// The emerging paths, as if they had been reflected at the far side: `scattered` is the energy
    /// s tau E that leaves it diffusely.
    PathBatch& emerging() { return *emerging_; }

    /// Adds the emerging paths to paths().
    void admit();

 private:
    float thin_out(double energy, std::uint64_t seed);

    const RayScene& scene_;
    Bands attenuation_per_m_;
    float max_length_m_;
    std::uint64_t seed_;
    std::uint64_t admissions_ = 0;
    double highest_energy_ = 0;
    double survival_ = 1;  ///< of all paths so far
    std::size_t places_ = kPlaces;
    std::vector<std::size_t> lanes_;  ///< [entry]
    std::vector<WallEntry> entries_;
    std::vector<WallExit> exits_;
    std::vector<Bands> energies_;
    std::vector<std::uint32_t> crossings_;
    Resampler resampler_;
    std::unique_ptr<PathBatch> paths_ = std::make_unique<PathBatch>();
    std::unique_ptr<PathBatch> next_ = std::make_unique<PathBatch>();
    std::unique_ptr<PathBatch> emerging_ = std::make_unique<PathBatch>();
};

}  // namespace aula
