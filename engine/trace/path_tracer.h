#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/base/time_bins.h"
#include "engine/patches/patch_grid.h"
#include "engine/patches/patch_subdivision.h"
#include "engine/rays/ray_scene.h"
#include "engine/rays/receiver.h"
#include "engine/trace/deposit.h"
#include "engine/trace/path_batch.h"
#include "engine/trace/path_identifier.h"
#include "engine/trace/specular_paths.h"

namespace aula {

/// The end of the paths that rays leave from: a source or, as sound travels both ways alike, a
/// listener.
struct Emitter {
    std::size_t id = 0;  ///< every emitter has its own random numbers and path identifiers
    Vec3 position{0};
    bool is_listener = false;  ///< it is a listener, and receivers are sources
};

/// A ray that crossed a receiver's sphere after its last reflection.
struct Arrival {
    PathIdentifier path;  ///< emitter, patches, receiver
    std::uint32_t receiver = 0;
    float length_m = 0;  ///< of the path, to the middle of the chord
    Vec3 direction{0};   ///< unit, from the listener to where sound comes from, at whichever end
    Bands energy;        ///< energy * chord / sphere volume, 1/m2, for a ray of energy 1
    std::uint64_t image = 0;  ///< see SegmentEnergy
};

/// A segment of a path that no gather finds, on its way to whoever is there to hear it.
struct PathSegment {
    Vec3 origin{0};
    Vec3 direction{0};  ///< unit
    float length_m = 0;
    float before_m = 0;  ///< length of the path up to the segment
    float growth = 0;    ///< of its detection sphere, see size_spheres()
};

/// What a segment sounds like.
struct SegmentEnergy {
    Bands energy;  ///< where it begins, of a ray of energy 1
    Vec3 from{0};  ///< unit, from the listener to where sound comes from, at whichever end
    /// ImageTransform::key of a purely specular path that an image source may count, else 0. It is
    /// heard where that image is not tried (SpecularSound::tried).
    std::uint64_t image = 0;
};

/// The way of a ray, to be looked at.
struct PathLine {
    std::vector<Vec3> points;   ///< the source, then each reflection; in the open a last point
    std::vector<float> energy;  ///< [point] mean of all bands when it leaves there, 1 at the source
};

/// What one batch of rays found, in the order of rays within each reflection.
struct TraceBatch {
    std::vector<Arrival> arrivals;
    DepositParts deposits;
    std::vector<PathSegment> segments;
    std::vector<SegmentEnergy> segment_energies;      ///< [segment]
    std::vector<PathIdentifier> segment_identifiers;  ///< [segment] of a tracer with a subdivision
    std::vector<Vec3> departures;                     ///< [ray] the direction in which it left
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
    int rays = 1000;       ///< of an emitter in a frame, at most
    int order = 0;         ///< highest reflection order; 0: no limit
    bool specular = true;  ///< false leaves out purely specular paths of every order
    float max_length_m = 343;
    float speed_of_sound_m_s = 343.2F;
    Bands attenuation_per_m;
    bool independent_rays = false;  ///< random first directions in place of stratified ones
};

/// Monte Carlo path tracing from an emitter: rays of energy 1 in every band, reflected diffusely or
/// specularly by the scattering coefficient, until the response ends or unbiased roulette ends them
/// below -80 dB. Const, so that several threads may trace batches together. Purely specular paths
/// of the orders of which `images` tries every sequence are left to it; those of its higher orders
/// carry their image's key, for the reader to leave out what it counts. [propagation thread]
class PathTracer {
 public:
    /// Rays of a batch; batches do not depend on threads, so neither do results.
    static constexpr int kBatchRays = static_cast<int>(kLanes);

    /// Collects arrivals at receivers of paths that were reflected diffusely, and the segments of
    /// all others, each with its path identifier.
    PathTracer(const RayScene& scene, const PatchSubdivision& subdivision,
               const SpecularPaths& images, const TraceSettings& settings);

    /// Collects deposits on the cells of a grid, and the segments of paths that no gather finds:
    /// the purely specular ones and, where the order has a limit, all that end in a mirror. (A
    /// patch does not know the order of what it radiates, so that a gather ray cannot tell whether
    /// it may go on.) Receivers are not asked for.
    PathTracer(const RayScene& scene, const PatchGrid& grid, const TimeBins& bins,
               const SpecularPaths& images, const TraceSettings& settings);

    /// Other rays of an emitter from the next frame on.
    void set_rays(int rays) { settings_.rays = rays; }

    int batch_count() const { return (settings_.rays + kBatchRays - 1) / kBatchRays; }

    /// Rays of the first batches together.
    int rays_of(int batches) const { return std::min(batches * kBatchRays, settings_.rays); }

    /// Traces one batch of an emitter's rays. `frame_seed` is one for each frame.
    void trace(const Emitter& emitter, std::span<const Receiver> receivers,
               std::uint64_t frame_seed, int batch, TraceBatch& out) const;

    /// The first `count` paths that trace() follows in a frame, up to a reflection order.
    std::vector<PathLine> lines(const Emitter& emitter, std::uint64_t frame_seed, int count,
                                int order) const;

    /// The rays that trace() sends for a batch, in its order, to be traced elsewhere.
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
