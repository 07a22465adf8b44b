#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "aula/engine/frame.h"
#include "engine/rays/oriented_directivity.h"
#include "engine/rays/ray_scene.h"
#include "engine/trace/path_batch.h"
#include "engine/trace/specular_paths.h"
#include "engine/trace/trace_batch.h"
#include "engine/trace/transmitted_paths.h"

namespace aula {

/// The point that rays leave from: a source or, by reciprocity, a listener.
struct Emitter {
    std::size_t id = 0;  ///< selects the random numbers and path identifiers
    Vec3 position{0};
    bool is_listener = false;           ///< true: a listener emits and the receivers are sources
    OrientedDirectivity directivity{};  ///< of a source
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

/// Monte Carlo path tracing from an emitter. The energy of a ray is 1 in every band; rays of a
/// source with a directivity have it in the mean. Surfaces reflect them diffusely or specularly by
/// the scattering coefficient; a purely specular path may also go on beside the diffuse one
/// (`divides`). Rays end with the response or, below -30 dB, by unbiased Russian roulette. Purely
/// specular paths of the orders at which `images` tries every sequence are omitted. Those of its
/// higher orders carry the key of their image, so that paths that image sources count can be
/// omitted later. ArrivalTracer and DepositTracer select what is collected. Const functions may run
/// on several threads. [propagation thread]
class PathTracer {
 public:
    /// Rays per batch at most.
    static constexpr int kBatchRays = static_cast<int>(kLanes);

    /// Sets the rays per emitter from the next frame on.
    void set_rays(int rays) { settings_.rays = rays; }

    /// Batches are about equally large. They do not depend on the number of threads, so neither do
    /// the results.
    int batch_count() const;

    /// Number of rays in the first `batches` batches.
    int rays_of(int batches) const;

    /// The first `count` paths of a frame, up to reflection order `order`. `frame_seed` is common
    /// to all batches of a frame.
    std::vector<PathLine> lines(const Emitter& emitter, std::uint64_t frame_seed, int count,
                                int order) const;

    /// The rays of a batch in the order in which they are traced, for tracing by other code.
    std::vector<Ray> rays(const Emitter& emitter, std::uint64_t frame_seed, int batch) const;

 protected:
    /// `divides`: purely specular paths go on beside the diffuse ones.
    PathTracer(const RayScene& scene, const SpecularPaths& images, const TraceSettings& settings,
               bool divides = false)
        : scene_(scene), images_(images), settings_(settings), divides_(divides) {}

    /// Which paths of a ray are traced: one, which every reflection sends to one lobe, or also
    /// those behind walls that transmit and, if `divides_`, purely specular ones.
    enum class Paths { one_of_a_ray, all };

    /// Traces a batch's rays by reflection order, up to order `last_order`. A PathBatch holds the
    /// next segment of every path; paths behind walls, whose passages count as reflections, have
    /// their own, and so have, if `divides_`, the purely specular paths of rays that have been
    /// reflected diffusely. Calls `add_segments(paths, order)` when the segments' hits are known,
    /// and `add_reflections(paths)` when the energies at those hits are known, the same with paths
    /// that emerge from walls.
    template <typename AddSegments, typename AddReflections>
    void follow(const Emitter& emitter, std::uint64_t frame_seed, int batch, int last_order,
                Paths which, const AddSegments& add_segments,
                const AddReflections& add_reflections) const {
        const auto memory = std::make_unique<PathBatch>();
        PathBatch& paths = *memory;
        start(emitter, frame_seed, batch, paths);
        std::unique_ptr<TransmittedPaths> behind;
        std::unique_ptr<PathBatch> mirrored;
        if (which == Paths::all) {
            behind = transmitted(emitter, frame_seed, batch);
            if (divides_) {
                paths.lobes = PathBatch::Lobes::both;
                mirrored = std::make_unique<PathBatch>();
                mirrored->lobes = PathBatch::Lobes::mirrored;
            }
        }
        const auto advance = [&](PathBatch& present, int order) {
            scene_.intersect(present.rays, present.count, present.hits);
            add_segments(present, order);
            if (order == last_order) return;
            present.remove_escaped();
            extend_images(present, order, emitter);
            present.arrive(scene_);
            if (behind) behind->transmit(present, order);
            present.scatter(scene_, settings_.attenuation_per_m);
            add_reflections(present);
            if (present.lobes == PathBatch::Lobes::both) {
                mirrored->take_mirrored(present, settings_.max_length_m);
            }
            present.leave(settings_.max_length_m);
            present.remove_ended();
            if (!behind) return;
            if (behind->emerging().count > 0) add_reflections(behind->emerging());
            behind->admit();
        };
        const auto any_behind = [&] { return behind && behind->paths().count > 0; };
        const auto any_mirrored = [&] { return mirrored && mirrored->count > 0; };
        for (int order = 0; paths.count > 0 || any_behind() || any_mirrored(); ++order) {
            // Paths that begin at the hits of others begin with the next order.
            if (any_behind()) advance(behind->paths(), order);
            if (any_mirrored()) advance(*mirrored, order);
            if (paths.count > 0) advance(paths, order);
            if (order == last_order) break;
        }
    }

    bool order_is_limited() const { return settings_.order > 0; }

    /// Highest reflection order that is traced.
    int last_order() const {
        return order_is_limited() ? settings_.order : std::numeric_limits<int>::max();
    }

    /// True if rays count some of the purely specular paths of a batch, whose order is `order`.
    /// SpecularPaths finds the direct sound and the listed sequences exactly, but no image source
    /// behind a wall.
    bool traces_specular_of(const PathBatch& paths, int order) const {
        return settings_.specular && (paths.behind_walls || images_.leaves_to_rays(order));
    }

    /// In such a batch: true if path `i` is purely specular and counts. The straight path through
    /// walls is a part of the direct sound.
    bool counts_specular(const PathBatch& paths, int order, std::size_t i) const {
        if (paths.diffuse[i] != 0) return false;
        if (paths.behind_walls) return paths.reflected[i] != 0;
        return order > images_.listed_order() || !paths.image[i].may_be_image;
    }

    /// Counts the present segments of all paths; records their directions at order 0.
    static void count_segments(const PathBatch& paths, int order, TraceBatch& out);

    /// Adds the present segment of path `i`.
    void add_segment(const PathBatch& paths, std::size_t i, int order, const Emitter& emitter,
                     TraceBatch& out) const;

    /// The direction at the listener of the sound that the present segment of path `i` brings.
    static Vec3 direction_at_listener(const PathBatch& paths, std::size_t i, const Emitter& emitter,
                                      const TraceBatch& batch) {
        return emitter.is_listener ? batch.departures[paths.ray[i]] : -paths.rays.direction.at(i);
    }

    const RayScene& scene() const { return scene_; }
    const TraceSettings& settings() const { return settings_; }

 private:
    void start(const Emitter& emitter, std::uint64_t frame_seed, int batch, PathBatch& paths) const;
    std::unique_ptr<TransmittedPaths> transmitted(const Emitter& emitter, std::uint64_t frame_seed,
                                                  int batch) const;
    void extend_images(PathBatch& paths, int order, const Emitter& emitter) const;

    const RayScene& scene_;
    const SpecularPaths& images_;
    TraceSettings settings_;
    bool divides_;
};

}  // namespace aula
