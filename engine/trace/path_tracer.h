#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "aula/engine/frame.h"
#include "aula/engine/time_bins.h"
#include "engine/patches/patch_grid.h"
#include "engine/patches/patch_subdivision.h"
#include "engine/rays/ray_scene.h"
#include "engine/rays/receiver.h"
#include "engine/trace/deposit.h"
#include "engine/trace/path_batch.h"
#include "engine/trace/path_identifier.h"
#include "engine/trace/specular_paths.h"

namespace aula {

/// The point that rays leave from: a source or, by reciprocity, a listener.
struct Emitter {
    std::size_t id = 0;  ///< selects the random numbers and path identifiers
    Vec3 position{0};
    bool is_listener = false;  ///< true: a listener emits and the receivers are sources
};

/// A ray that crossed a receiver's sphere after its last reflection.
struct Arrival {
    PathIdentifier path;  ///< emitter, patches, receiver
    std::uint32_t receiver = 0;
    float length_m = 0;  ///< path length to the middle of the chord
    Vec3 direction{0};  ///< unit, from the listener to the origin of the sound, whichever end emits
    Bands energy;       ///< energy * chord / sphere volume, 1/m2, for a ray of energy 1
    std::uint64_t image = 0;  ///< see SegmentEnergy
};

/// A segment of a path that no gather finds; receivers detect it later.
struct PathSegment {
    Vec3 origin{0};
    Vec3 direction{0};  ///< unit
    float length_m = 0;
    float before_m = 0;  ///< length of the path up to the segment
    float growth = 0;    ///< of its detection sphere, see size_spheres()
};

/// Energy and direction of a segment.
struct SegmentEnergy {
    Bands energy;  ///< at the segment's start, for a ray of energy 1
    Vec3 from{0};  ///< unit, from the listener to the origin of the sound, whichever end emits
    /// ImageTransform::key of a purely specular path that an image source may count, else 0. The
    /// path contributes where that image is not tried (SpecularSound::tried).
    std::uint64_t image = 0;
};

/// Results of one batch of rays, ordered by reflection, then by ray.
struct TraceBatch {
    std::vector<Arrival> arrivals;
    DepositParts deposits;
    std::vector<PathSegment> segments;
    std::vector<SegmentEnergy> segment_energies;  ///< [segment]
    std::vector<PathIdentifier>
        segment_identifiers;       ///< [segment] only of a tracer with a subdivision
    std::vector<Vec3> departures;  ///< [ray] initial direction
    std::uint64_t segment_count = 0;

    void clear() {
        arrivals.clear();
        deposits.clear();
        segments.clear();
        segment_energies.clear();
        segment_identifiers.clear();
        departures.clear();
        segment_count = 0;
    }
};

struct TraceSettings {
    int rays = 1000;       ///< per emitter and frame, at most
    int order = 0;         ///< highest reflection order; 0: no limit
    bool specular = true;  ///< false leaves out purely specular paths of every order
    float max_length_m = 343;
    float speed_of_sound_m_s = 343.2F;
    Bands attenuation_per_m;
    bool independent_rays = false;  ///< random initial directions instead of stratified ones
};

/// Monte Carlo path tracing from an emitter. Rays of energy 1 in every band are reflected diffusely
/// or specularly by the scattering coefficient. They end with the response or, below -80 dB, by
/// unbiased Russian roulette. Purely specular paths of the orders at which `images` tries every
/// sequence are omitted; those of its higher orders carry their image's key, so that the reader can
/// omit the paths that image sources count. trace() is const: several threads may trace batches in
/// parallel. [propagation thread]
class PathTracer {
 public:
    /// Rays per batch. Batches do not depend on the threads, so neither do the results.
    static constexpr int kBatchRays = static_cast<int>(kLanes);

    /// Collects the arrivals of diffusely reflected paths at receivers, and the segments of all
    /// other paths, each with its path identifier.
    PathTracer(const RayScene& scene, const PatchSubdivision& subdivision,
               const SpecularPaths& images, const TraceSettings& settings);

    /// Collects deposits on the cells of a grid, and the segments of paths that no gather finds:
    /// purely specular paths and, if the order is limited, all paths that end in a mirror. (A patch
    /// does not store the order of its energy, so a gather ray cannot tell whether a further
    /// reflection is within the limit.) Receivers are not used.
    PathTracer(const RayScene& scene, const PatchGrid& grid, const TimeBins& bins,
               const SpecularPaths& images, const TraceSettings& settings);

    /// Sets the rays per emitter from the next frame on.
    void set_rays(int rays) { settings_.rays = rays; }

    int batch_count() const { return (settings_.rays + kBatchRays - 1) / kBatchRays; }

    /// Number of rays in the first `batches` batches.
    int rays_of(int batches) const { return std::min(batches * kBatchRays, settings_.rays); }

    /// Traces one batch of an emitter's rays. `frame_seed` is common to all batches of a frame.
    void trace(const Emitter& emitter, std::span<const Receiver> receivers,
               std::uint64_t frame_seed, int batch, TraceBatch& out) const;

    /// The first `count` paths that trace() follows in a frame, up to reflection order `order`.
    std::vector<PathLine> lines(const Emitter& emitter, std::uint64_t frame_seed, int count,
                                int order) const;

    /// The rays that trace() emits for a batch, in the same order, for tracing by other code.
    std::vector<Ray> rays(const Emitter& emitter, std::uint64_t frame_seed, int batch) const;

 private:
    template <typename Sent>
    void trace_paths(const Emitter& emitter, std::span<const Receiver> receivers,
                     std::uint64_t frame_seed, int batch, TraceBatch& out, const Sent& sent) const;
    void start(const Emitter& emitter, std::uint64_t frame_seed, int batch, PathBatch& paths,
               TraceBatch& out) const;
    void extend_images(PathBatch& paths, int order, const Emitter& emitter) const;
    void collect_arrivals(const PathBatch& paths, int order, const Emitter& emitter,
                          std::span<const Receiver> receivers, TraceBatch& out) const;
    void collect_segments(const PathBatch& paths, int order, const Emitter& emitter,
                          TraceBatch& out) const;
    void reflect(PathBatch& paths, TraceBatch& out) const;
    void deposit(const PathBatch& paths, TraceBatch& out) const;

    const RayScene& scene_;
    const SpecularPaths& images_;
    const PatchSubdivision* subdivision_ = nullptr;
    const PatchGrid* grid_ = nullptr;
    const TimeBins* bins_ = nullptr;
    TraceSettings settings_;
};

}  // namespace aula
