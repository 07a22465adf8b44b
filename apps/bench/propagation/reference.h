#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <vector>

#include "apps/bench/base/settings.h"
#include "apps/bench/base/statistics.h"
#include "engine/base/worker_pool.h"
#include "engine/rays/image_transform.h"
#include "engine/rays/ray_scene.h"
#include "engine/trace/specular_paths.h"

namespace aula::bench {

/// The reference of all comparisons: path tracing with next-event estimation to the receivers, and
/// the image sources. It covers all reflected sound, as the estimators' bins and image sources do
/// together (estimated_energy). It shares ray queries, the sampling of directions and the image
/// sources with them. Deterministic for any number of threads.
class Reference {
 public:
    /// Radius R of the sphere over which paths that end in a mirror are averaged. The mean differs
    /// from the value at the centre by R^2 / 10 times the Laplacian of the fluence: by R^2 / (5
    /// d^2) for an image source at d metres, 0.02 % at 8 m, where the late response begins.
    static constexpr float kDetectionRadius_m = 0.25F;

    struct Estimate {
        double mean = 0;            ///< 1/m2 per unit emitted energy, summed over the bands
        double standard_error = 0;  ///< of the mean
    };

    /// Fluence at `receivers` from a source at `emitter`, in `bin_count` bins of kBin_s, with the
    /// scene's objects at their positions at `time_s`.
    Reference(const Scene& scene, const Simulation& simulation, double time_s, const Vec3& emitter,
              std::vector<Vec3> receivers, std::size_t bin_count);

    /// Traces at least `rays` more.
    void trace(std::uint64_t rays, WorkerPool& workers);

    std::uint64_t rays() const { return std::uint64_t{rounds_} * kBatchRays * kEstimates; }

    /// Energy in a range of bins.
    Estimate energy(std::size_t receiver, BinRange bins) const;

    /// Independent estimates of this energy, which is their mean.
    std::vector<double> estimates(std::size_t receiver, BinRange bins) const;

    /// Energy in every bin.
    std::vector<double> response(std::size_t receiver) const;

    /// Root of the mean over `bins` of the squared relative standard error of a bin.
    double relative_error(std::size_t receiver, BinRange bins) const;

 private:
    /// Independent estimates, whose spread gives the standard error.
    static constexpr std::size_t kEstimates = 64;
    static constexpr std::uint64_t kBatchRays = 256;

    struct Path;
    void add_image_sources();
    bool is_image(const Path& path, std::size_t receiver) const;
    std::size_t bin_of(float length_m) const;
    using Sums = std::vector<double>;  ///< [receiver * bin_count + bin]
    void trace_batch(std::uint64_t seed, Sums& sums) const;
    void next_event(const Path& path, const Vec3& normal, const Bands& radiated, float pick,
                    Sums& sums) const;
    static void add_surviving(Path path, std::vector<Path>& paths);
    void cross_detection_spheres(const Path& path, float segment_m, Sums& sums) const;
    void add(std::size_t receiver, float length_m, const Bands& energy, Sums& sums) const;

    RayScene scene_;
    Simulation simulation_;
    Vec3 emitter_;
    std::vector<Vec3> receivers_;
    std::size_t bin_count_;
    float speed_of_sound_m_s_;
    float max_length_m_;
    Bands attenuation_per_m_;
    std::optional<SpecularPaths> paths_;
    std::vector<SpecularSound> sounds_;  ///< [receiver]
    std::vector<Sums> estimates_;
    Sums images_;
    std::uint32_t rounds_ = 0;
};

/// True if a reference's relative error is at most this share of the error that is measured against
/// it. From a tenth on, the estimates of both errors are too uncertain to compare.
inline bool has_converged(double reference_error, double share, double measured_error) {
    constexpr double kReliable = 0.1;
    return reference_error <= std::min(kReliable, share * measured_error);
}

/// The extent of a reference that does not converge before: rays, and CPU time from the constructor
/// on.
class ReferenceLimit {
 public:
    explicit ReferenceLimit(const Settings& settings)
        : max_rays_(settings.reference_rays), end_s_(cpu_time_s() + settings.reference_s) {}

    bool reached(double rays) const { return rays >= max_rays_ || cpu_time_s() >= end_s_; }

 private:
    double max_rays_;
    double end_s_;
};

}  // namespace aula::bench
