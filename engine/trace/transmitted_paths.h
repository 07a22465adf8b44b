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
/// behind walls of a batch of up to kLanes rays is therefore limited by unbiased resampling after
/// each reflection (Thinning). Once transmitted, they are ordinary paths. [several threads]
class TransmittedPaths {
 public:
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
    const RayScene& scene_;
    Bands attenuation_per_m_;
    float max_length_m_;
    std::uint64_t seed_;
    std::uint64_t admissions_ = 0;
    Thinning thinning_;
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
