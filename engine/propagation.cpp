#include "engine/propagation.h"

#include <algorithm>
#include <cassert>
#include <chrono>
#include <cmath>
#include <glm/geometric.hpp>
#include <optional>
#include <thread>

#include "engine/arrival_window.h"
#include "engine/diffuse_path_cache.h"
#include "engine/error.h"
#include "engine/listener_gather.h"
#include "engine/off_surface.h"
#include "engine/patch_cache.h"
#include "engine/patch_grid.h"
#include "engine/path_tracer.h"
#include "engine/room_survey.h"
#include "engine/sampling.h"
#include "engine/specular_paths.h"
#include "engine/worker_pool.h"

namespace aula {

namespace {

constexpr double kLongestDefaultResponse_s = 4;
constexpr double kShortestDefaultResponse_s = 0.3;
constexpr int kGatherRays = 1024;

/// Shares of the memory for caches: the patches' sums, the log of frames that may be taken out.
constexpr double kTableShare = 0.6;
constexpr double kLogShare = 0.4;

enum class SeedPurpose : std::uint64_t { frame = 1, grid, survey, gather, specular };

int default_threads() {
    return std::max(1, static_cast<int>(std::thread::hardware_concurrency()) - 1);
}

/// Seconds since the last call.
class Stopwatch {
 public:
    double lap_s() {
        const auto now = std::chrono::steady_clock::now();
        const double s = std::chrono::duration<double>(now - last_).count();
        last_ = now;
        return s;
    }

 private:
    std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

/// Points where sound is: all places of sources and listener.
std::vector<Vec3> places(const Scene& scene) {
    std::vector<Vec3> points;
    const auto add = [&](const Vec3& position, const std::optional<Path>& path) {
        if (!path) points.push_back(position);
        if (path) {
            for (const Path::Point& point : path->points) points.push_back(point.pose.position);
        }
    };
    for (const Source& source : scene.sources) add(source.position, source.path);
    add(scene.listener.pose.position, scene.listener.path);
    return points;
}

void check(const Simulation& simulation) {
    const auto need = [](bool holds, const char* what) {
        if (!holds) throw Error(std::string("simulation: ") + what);
    };
    need(simulation.rays >= 1, "rays is below 1");
    need(simulation.order >= 0, "order is below 0");
    need(simulation.specular_order >= 0, "specular_order is below 0");
    need(simulation.patch_size_m > 0, "patch_size_m is not above 0");
    need(simulation.listener_radius_m > 0, "listener_radius_m is not above 0");
    need(simulation.frame_rate_hz > 0, "frame_rate_hz is not above 0");
    need(simulation.response_time_s >= 0, "response_time_s is below 0");
    need(simulation.memory_mb >= 1, "memory_mb is below 1");
    need(!simulation.threads || *simulation.threads >= 1, "threads is below 1");
    need(!simulation.ir_length_s || (*simulation.ir_length_s > 0 && *simulation.ir_length_s <= 10),
         "ir_length_s is not between 0 and 10");
}

}  // namespace

struct Propagation::State {
    Scene scene;
    Simulation simulation;
    std::size_t listener_count;
    float speed_of_sound_m_s;
    Bands attenuation_per_m;
    RayScene rays;
    WorkerPool workers;
    std::vector<Vec3> inside;
    TimeBins bins;
    std::optional<PatchSubdivision> subdivision;  // pt, dpc*
    std::optional<PatchGrid> grid;                // patch
    std::optional<PathTracer> tracer;
    SpecularPaths specular;

    // [source]
    std::vector<PatchCache> patch_caches;
    // [source * listener_count + listener]
    std::vector<DiffusePathCache> path_caches;
    std::vector<ArrivalWindow> arrivals;
    std::vector<EnergyResponse> responses;

    std::uint64_t seed;
    std::uint64_t frame = 0;
    double travel_m = 0;  // how far anything in the scene has moved since the start
    std::vector<std::vector<TraceBatch>> batches;  // [source][batch]
    FrameStatistics statistics;

    State(const Scene& given, const Simulation& settings, std::size_t listeners)
        : scene(given),
          simulation((check(settings), settings)),
          listener_count(listeners),
          speed_of_sound_m_s(scene.medium.speed_of_sound_m_s()),
          attenuation_per_m(scene.medium.attenuation_per_m()),
          rays(scene),
          workers(settings.threads.value_or(default_threads())),
          inside(places(scene)),
          bins(response_length_s()),
          specular(rays, image_source_order(), derive_seed(settings.seed, SeedPurpose::specular)),
          seed(settings.seed) {
        TraceSettings trace;
        trace.rays = simulation.rays;
        trace.order = simulation.order;
        trace.specular_order = simulation.specular_order;
        trace.specular = simulation.specular;
        trace.max_length_m = static_cast<float>(bins.length_s()) * speed_of_sound_m_s;
        trace.listener_radius_m = simulation.listener_radius_m;
        trace.speed_of_sound_m_s = speed_of_sound_m_s;
        trace.attenuation_per_m = attenuation_per_m;
        if (simulation.estimator == Estimator::patch) {
            make_grid();
            tracer.emplace(rays, *grid, bins, trace);
        } else {
            subdivision.emplace(rays, simulation.patch_size_m);
            tracer.emplace(rays, *subdivision, trace);
        }
        batches.resize(scene.sources.size());
        for (auto& of_source : batches) {
            of_source.resize(static_cast<std::size_t>(tracer->batch_count()));
        }
        make_caches();
    }

    /// Highest order of the image sources; the limit of all orders holds for them, too.
    int image_source_order() const {
        if (!simulation.specular) return 0;
        return simulation.order > 0 ? std::min(simulation.order, simulation.specular_order)
                                    : simulation.specular_order;
    }

    double response_length_s() const {
        if (simulation.ir_length_s) return double{*simulation.ir_length_s};
        const RoomSurvey survey =
            survey_room(rays, inside, derive_seed(simulation.seed, SeedPurpose::survey));
        double length_s = double{reverberation_time_s(survey, scene.medium).max()};
        // Direct sound has to fit in the open, too.
        for (const Vec3& a : inside) {
            for (const Vec3& b : inside) {
                length_s = std::max(length_s,
                                    0.1 + double{glm::distance(a, b)} / double{speed_of_sound_m_s});
            }
        }
        return std::clamp(length_s, kShortestDefaultResponse_s, kLongestDefaultResponse_s);
    }

    double memory_bytes(double share) const { return share * simulation.memory_mb * 1e6; }

    /// Patches of the wanted size, or larger ones where their sums would not fit in memory.
    void make_grid() {
        const double row_bytes =
            static_cast<double>(bins.count() * kBandCount * sizeof(std::int64_t));
        const double most_rows =
            std::max(16.0, memory_bytes(kTableShare) / row_bytes /
                               static_cast<double>(std::max<std::size_t>(1, scene.sources.size())));
        double surface_m2 = 0;
        for (const RayScene::Triangle& t : rays.triangles()) {
            surface_m2 += double{glm::length(glm::cross(t.vertices[1] - t.vertices[0],
                                                        t.vertices[2] - t.vertices[0]))} /
                          2;
        }
        // Both sides of every triangle may be cells, of which only those in the room need sums.
        float size_m = std::max(simulation.patch_size_m,
                                static_cast<float>(std::sqrt(surface_m2 / (4 * most_rows))));
        for (;; size_m *= 1.25F) {
            grid.emplace(rays, size_m, inside, derive_seed(simulation.seed, SeedPurpose::grid),
                         workers);
            if (static_cast<double>(grid->reached()) <= most_rows) break;
        }
    }

    void make_caches() {
        const std::size_t pairs = scene.sources.size() * listener_count;
        const int window = simulation.window_frames();
        patch_caches.clear();
        path_caches.clear();
        arrivals.clear();
        responses.assign(pairs, EnergyResponse{});
        for (EnergyResponse& response : responses) {
            response.bins = bins;
            response.speed_of_sound_m_s = speed_of_sound_m_s;
            response.energy.resize(bins.count());
            response.direction.resize(bins.count());
        }
        const auto share_of = [&](double share, std::size_t parts) {
            return static_cast<std::size_t>(memory_bytes(share) / static_cast<double>(parts));
        };
        switch (simulation.estimator) {
            case Estimator::pt:
                arrivals.assign(pairs, ArrivalWindow(1, simulation.listener_radius_m));
                break;
            case Estimator::dpc_published:
            case Estimator::dpc:
                for (std::size_t i = 0; i < pairs; ++i) {
                    path_caches.emplace_back(simulation.estimator == Estimator::dpc
                                                 ? DiffusePathCache::Readout::windowed
                                                 : DiffusePathCache::Readout::published,
                                             window, share_of(1, pairs));
                }
                break;
            case Estimator::patch:
                arrivals.assign(pairs, ArrivalWindow(window, simulation.listener_radius_m));
                for (std::size_t s = 0; s < scene.sources.size(); ++s) {
                    patch_caches.emplace_back(bins.count(), window, grid->patch_size_m(),
                                              share_of(kLogShare, scene.sources.size()));
                }
                break;
        }
    }

    /// The frame's places, those on surfaces moved off them, or half of their rays were lost.
    FrameInput off_surfaces(const FrameInput& given) const {
        FrameInput input = given;
        for (Vec3& source : input.sources) source = off_surface(rays, source);
        for (Vec3& listener : input.listeners) listener = off_surface(rays, listener);
        return input;
    }

    std::uint64_t frame_seed() const { return derive_seed(seed, SeedPurpose::frame, frame); }

    /// Source and batch of what is traced in this frame.
    std::vector<std::pair<std::size_t, std::size_t>> trace_jobs(const FrameInput& input) const {
        std::vector<std::pair<std::size_t, std::size_t>> jobs;
        for (std::size_t s = 0; s < batches.size(); ++s) {
            if (simulation.estimator == Estimator::patch &&
                patch_caches[s].complete(input.sources[s], travel_m)) {
                continue;
            }
            for (std::size_t b = 0; b < batches[s].size(); ++b) jobs.emplace_back(s, b);
        }
        return jobs;
    }

    void trace(const FrameInput& input, std::uint64_t frame_seed) {
        for (auto& of_source : batches) {
            for (TraceBatch& batch : of_source) batch.clear();
        }
        const auto jobs = trace_jobs(input);
        workers.run(jobs.size(), [&](std::size_t job) {
            const auto [s, b] = jobs[job];
            tracer->trace(s, input.sources[s], input.listeners, frame_seed, static_cast<int>(b),
                          batches[s][b]);
        });
        for (const auto& of_source : batches) {
            for (const TraceBatch& batch : of_source) statistics.segments += batch.segments;
        }
    }

    void update_caches(const FrameInput& input) {
        for (std::size_t s = 0; s < batches.size(); ++s) {
            if (batches[s].front().segments == 0) continue;  // not traced: its cache is complete
            std::vector<std::vector<Arrival>> at(listener_count);
            for (const TraceBatch& batch : batches[s]) {
                for (const Arrival& arrival : batch.arrivals) {
                    at[arrival.listener].push_back(arrival);
                }
            }
            for (std::size_t l = 0; l < listener_count; ++l) {
                const std::size_t pair = s * listener_count + l;
                if (!path_caches.empty()) path_caches[pair].add_frame(at[l], simulation.rays);
                if (!arrivals.empty()) {
                    arrivals[pair].add_frame(input.sources[s], input.listeners[l], travel_m, at[l],
                                             simulation.rays);
                }
            }
            if (!patch_caches.empty()) {
                patch_caches[s].add_frame(input.sources[s], travel_m, simulation.rays, grid->size(),
                                          batches[s], workers);
            }
        }
    }

    GatherSettings gather_settings() const {
        GatherSettings settings;
        settings.rays = kGatherRays;
        settings.order = simulation.order;
        settings.max_length_m = static_cast<float>(bins.length_s()) * speed_of_sound_m_s;
        settings.attenuation_per_m = attenuation_per_m;
        return settings;
    }

    void respond(const FrameInput& input, std::uint64_t frame_seed) {
        for (EnergyResponse& response : responses) {
            std::fill(response.energy.begin(), response.energy.end(), Bands{});
            std::fill(response.direction.begin(), response.direction.end(), Vec3(0));
        }
        for (std::size_t i = 0; i < path_caches.size(); ++i) path_caches[i].add_to(responses[i]);
        for (std::size_t i = 0; i < arrivals.size(); ++i) arrivals[i].add_to(responses[i]);
        if (patch_caches.empty()) return;
        const GatherSettings settings = gather_settings();
        for (std::size_t l = 0; l < listener_count; ++l) {
            const std::vector<GatherHit> hits = trace_gather(
                rays, *grid, input.listeners[l], settings,
                derive_seed(frame_seed, SeedPurpose::gather, l), workers, statistics.segments);
            for (std::size_t s = 0; s < patch_caches.size(); ++s) {
                add_gathered(hits, patch_caches[s], workers, responses[s * listener_count + l]);
            }
        }
    }

    void find_specular(const FrameInput& input) {
        for (const Vec3& listener : input.listeners) specular.discover(listener, frame);
        workers.run(responses.size(), [&](std::size_t pair) {
            responses[pair].paths = specular.find(input.sources[pair / listener_count],
                                                  input.listeners[pair % listener_count],
                                                  simulation.direct, attenuation_per_m);
        });
    }

    void count_caches() {
        for (const PatchCache& cache : patch_caches) {
            statistics.cache_entries += cache.occupied();
            statistics.memory_bytes += cache.memory_bytes();
        }
        for (const DiffusePathCache& cache : path_caches) {
            statistics.cache_entries += cache.size();
            statistics.memory_bytes += cache.memory_bytes();
        }
        for (const ArrivalWindow& window : arrivals) {
            statistics.memory_bytes += window.memory_bytes();
        }
    }
};

Propagation::Propagation(const Scene& scene, const Simulation& simulation,
                         std::size_t listener_count)
    : state_(std::make_unique<State>(scene, simulation, listener_count)) {
    assert(listener_count >= 1);
}

Propagation::~Propagation() = default;

void Propagation::step(const FrameInput& given) {
    State& s = *state_;
    assert(given.sources.size() == s.scene.sources.size());
    assert(given.listeners.size() == s.listener_count);
    s.statistics = {};
    Stopwatch watch;
    const std::uint64_t frame_seed = s.frame_seed();

    // Move what moves.
    const float moved_m = s.rays.move(given.time_s);
    if (moved_m > 0) {
        s.travel_m += double{moved_m};
        s.specular.scene_moved();
        if (s.grid) s.grid->scene_moved();
    }
    const FrameInput input = s.off_surfaces(given);

    // Trace rays from every source; update the caches with what they found.
    s.trace(input, frame_seed);
    s.statistics.trace_s = watch.lap_s();
    s.update_caches(input);
    s.statistics.cache_s = watch.lap_s();

    // Read out the response of every source at every listener.
    s.respond(input, frame_seed);
    s.statistics.gather_s = watch.lap_s();
    s.find_specular(input);
    s.statistics.specular_s = watch.lap_s();
    s.count_caches();
    ++s.frame;
}

std::vector<Ray> Propagation::rays(const FrameInput& given) const {
    const State& s = *state_;
    const FrameInput input = s.off_surfaces(given);
    const std::uint64_t frame_seed = s.frame_seed();
    std::vector<Ray> all;
    const auto append = [&](const std::vector<Ray>& more) {
        all.insert(all.end(), more.begin(), more.end());
    };
    for (const auto& [source, batch] : s.trace_jobs(input)) {
        append(s.tracer->rays(source, input.sources[source], frame_seed, static_cast<int>(batch)));
    }
    for (std::size_t l = 0; s.grid && l < s.listener_count; ++l) {
        append(gather_rays(s.rays, *s.grid, input.listeners[l], s.gather_settings(),
                           derive_seed(frame_seed, SeedPurpose::gather, l)));
    }
    return all;
}

const EnergyResponse& Propagation::response(std::size_t source, std::size_t listener) const {
    return state_->responses[source * state_->listener_count + listener];
}

void Propagation::restart(std::uint64_t seed) {
    state_->seed = seed;
    state_->frame = 0;
    state_->make_caches();
}

const FrameStatistics& Propagation::statistics() const { return state_->statistics; }

std::vector<PathLine> Propagation::path_lines(const FrameInput& input, std::size_t source,
                                              int count, int order) const {
    const State& s = *state_;
    if (s.frame == 0) return {};
    const int most = s.simulation.order > 0 ? std::min(order, s.simulation.order) : order;
    return s.tracer->lines(source, input.sources[source],
                           derive_seed(s.seed, SeedPurpose::frame, s.frame - 1), count, most);
}

std::vector<PatchEnergy> Propagation::patch_energies(std::size_t source, double begin_s,
                                                     double end_s) const {
    const State& s = *state_;
    if (s.patch_caches.empty()) return {};
    return aula::patch_energies(*s.grid, s.patch_caches[source], s.bins, begin_s, end_s);
}

float Propagation::patch_size_m() const { return state_->grid ? state_->grid->patch_size_m() : 0; }

void Propagation::set_rays(int rays) {
    State& s = *state_;
    s.simulation.rays = rays;
    s.tracer->set_rays(rays);
    for (auto& of_source : s.batches)
        of_source.resize(static_cast<std::size_t>(s.tracer->batch_count()));
}

double Propagation::response_length_s() const {
    const auto& given = state_->simulation.ir_length_s;
    return given ? double{*given} : state_->bins.length_s();
}

}  // namespace aula
