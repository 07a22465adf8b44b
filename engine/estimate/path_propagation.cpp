#include "engine/estimate/path_propagation.h"

#include <algorithm>
#include <numeric>

#include "engine/base/stopwatch.h"
#include "engine/trace/detection_spheres.h"

namespace aula {

namespace {

std::optional<DiffusePathCache::Readout> readout_of(Estimator estimator) {
    switch (estimator) {
        case Estimator::dpc_published:
            return DiffusePathCache::Readout::published;
        case Estimator::dpc:
            return DiffusePathCache::Readout::windowed;
        default:
            return std::nullopt;
    }
}

/// Adds the arrivals of a frame that no image source counts, each at its delay, as a mean over the
/// frame's rays.
void add_arrivals(std::span<const Arrival> arrivals, int rays, const SpecularSound& images,
                  EnergyResponse& response) {
    const float scale = 1 / static_cast<float>(rays);
    for (const Arrival& arrival : arrivals) {
        if (images.has_tried(arrival.image)) continue;
        const Bands energy = arrival.energy * scale;
        response.add(double{arrival.length_m}, energy,
                     DirectionMoments::of(arrival.direction) * energy.sum());
    }
}

}  // namespace

PathPropagation::PathPropagation(const RayScene& scene, const SpecularPaths& images,
                                 const Simulation& simulation, const TraceSettings& trace,
                                 std::size_t source_count, std::size_t listener_count,
                                 WorkerPool& workers)
    : scene_(scene),
      workers_(workers),
      readout_(readout_of(simulation.estimator)),
      window_frames_(simulation.window_frames()),
      memory_bytes_(simulation.memory_mb * 1e6),
      listener_radius_m_(simulation.listener_radius_m),
      attenuation_per_m_(trace.attenuation_per_m),
      listener_count_(listener_count),
      subdivision_(scene, simulation.patch_size_m),
      tracer_(scene, subdivision_, images, trace),
      ids_(source_count),
      batches_(source_count) {
    std::iota(ids_.begin(), ids_.end(), std::size_t{0});
    set_rays(trace.rays);
    restart();
}

void PathPropagation::set_rays(int rays) {
    tracer_.set_rays(rays);
    for (auto& of_source : batches_) {
        of_source.resize(static_cast<std::size_t>(tracer_.batch_count()));
    }
}

/// The memory limit of one cache.
std::size_t PathPropagation::cache_bytes() const {
    const std::size_t pairs = std::max<std::size_t>(1, ids_.size() * listener_count_);
    return static_cast<std::size_t>(memory_bytes_ / static_cast<double>(pairs));
}

/// Divides the memory among the caches after their number has changed.
void PathPropagation::divide_memory() {
    for (DiffusePathCache& cache : caches_) cache.set_memory_bytes(cache_bytes());
}

/// Appends the caches of one source at all listeners.
void PathPropagation::add_caches() {
    if (!readout_) return;
    for (std::size_t l = 0; l < listener_count_; ++l) {
        caches_.emplace_back(*readout_, window_frames_, cache_bytes());
    }
}

void PathPropagation::restart() {
    caches_.clear();
    for (std::size_t s = 0; s < ids_.size(); ++s) add_caches();
}

void PathPropagation::add_source(std::size_t id, const Vec3& /*position*/,
                                 const OrientedDirectivity& /*directivity*/) {
    ids_.push_back(id);
    batches_.emplace_back(static_cast<std::size_t>(tracer_.batch_count()));
    add_caches();
    divide_memory();
}

void PathPropagation::remove_source(std::size_t source) {
    const auto index = static_cast<std::ptrdiff_t>(source);
    ids_.erase(ids_.begin() + index);
    batches_.erase(batches_.begin() + index);
    if (!readout_) return;
    const auto listeners = static_cast<std::ptrdiff_t>(listener_count_);
    const auto first = caches_.begin() + index * listeners;
    caches_.erase(first, first + listeners);
    divide_memory();
}

Emitter PathPropagation::emitter(std::size_t source, const PropagationFrame& frame) const {
    return {ids_[source], frame.input.sources[source], false, frame.directivities[source]};
}

/// Traces all batches, then collects the arrivals on their segments, whose detection spheres depend
/// on all batches of a source.
void PathPropagation::trace(const PropagationFrame& frame) {
    std::vector<Receiver> receivers;
    for (const Vec3& listener : frame.input.listeners) {
        receivers.push_back(make_receiver(scene_, listener, listener_radius_m_));
    }
    const auto batch_count = static_cast<std::size_t>(tracer_.batch_count());
    workers_.run(batches_.size() * batch_count, [&](std::size_t job) {
        const std::size_t source = job / batch_count;
        const std::size_t b = job % batch_count;
        ArrivalBatch& batch = batches_[source][b];
        batch.clear();
        tracer_.trace(emitter(source, frame), receivers, frame.seed, static_cast<int>(b), batch);
    });
    for (std::vector<ArrivalBatch>& of_source : batches_) size_spheres(std::span(of_source));
    workers_.run(batches_.size() * batch_count, [&](std::size_t job) {
        collect_segment_arrivals(scene_, receivers, attenuation_per_m_, ray_count(),
                                 batches_[job / batch_count][job % batch_count]);
    });
}

void PathPropagation::step(const PropagationFrame& frame, std::span<const SpecularSound> images,
                           std::span<EnergyResponse> responses, FrameStatistics& statistics) {
    Stopwatch watch;
    trace(frame);
    statistics.trace_s += watch.lap_s();
    for (std::size_t s = 0; s < batches_.size(); ++s) {
        std::vector<std::vector<Arrival>> at(listener_count_);
        for (const ArrivalBatch& batch : batches_[s]) {
            statistics.segments += batch.segment_count;
            for (const Arrival& arrival : batch.arrivals) at[arrival.receiver].push_back(arrival);
        }
        for (std::size_t l = 0; l < listener_count_; ++l) {
            const std::size_t pair = s * listener_count_ + l;
            EnergyResponse& response = responses[pair];
            response.clear_bins();
            if (!readout_) {
                add_arrivals(at[l], ray_count(), images[pair], response);
                statistics.memory_bytes += at[l].capacity() * sizeof(Arrival);
                continue;
            }
            DiffusePathCache& cache = caches_[pair];
            cache.add_frame(at[l], ray_count());
            cache.add_to(images[pair], response);
            statistics.cache_entries += cache.size();
            statistics.memory_bytes += cache.memory_bytes();
        }
    }
    statistics.cache_s += watch.lap_s();
}

std::vector<Ray> PathPropagation::rays(const PropagationFrame& frame) const {
    std::vector<Ray> all;
    for (std::size_t s = 0; s < ids_.size(); ++s) {
        for (int b = 0; b < tracer_.batch_count(); ++b) {
            const std::vector<Ray> more = tracer_.rays(emitter(s, frame), frame.seed, b);
            all.insert(all.end(), more.begin(), more.end());
        }
    }
    return all;
}

std::vector<PathLine> PathPropagation::path_lines(const PropagationFrame& frame, std::size_t source,
                                                  int count, int order) const {
    return tracer_.lines(emitter(source, frame), frame.seed, count, order);
}

}  // namespace aula
