#include "engine/estimate/path_propagation.h"

#include <algorithm>

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
      tracer_(scene, subdivision_, images, trace) {
    for (std::size_t id = 0; id < source_count; ++id) sources_.push_back(make_source(id));
    divide_memory();
}

void PathPropagation::set_rays(int rays) {
    tracer_.set_rays(rays);
    for (TracedSource& source : sources_)
        source.batches.resize(static_cast<std::size_t>(tracer_.batch_count()));
}

/// Divides the memory among the caches after their number has changed.
void PathPropagation::divide_memory() {
    const auto pairs = static_cast<double>(sources_.size() * listener_count_);
    for (TracedSource& source : sources_) {
        for (DiffusePathCache& cache : source.caches)
            cache.set_memory_bytes(static_cast<std::size_t>(memory_bytes_ / pairs));
    }
}

/// A source with empty caches, whose memory divide_memory() limits.
PathPropagation::TracedSource PathPropagation::make_source(std::size_t id) const {
    TracedSource source{
        id, std::vector<ArrivalBatch>(static_cast<std::size_t>(tracer_.batch_count())), {}};
    for (std::size_t l = 0; readout_ && l < listener_count_; ++l)
        source.caches.emplace_back(*readout_, window_frames_, 0);
    return source;
}

void PathPropagation::restart() {
    for (TracedSource& source : sources_) source = make_source(source.id);
    divide_memory();
}

void PathPropagation::add_source(std::size_t id, const Vec3& /*position*/,
                                 const OrientedDirectivity& /*directivity*/) {
    sources_.push_back(make_source(id));
    divide_memory();
}

void PathPropagation::remove_source(std::size_t source) {
    sources_.erase(sources_.begin() + static_cast<std::ptrdiff_t>(source));
    divide_memory();
}

Emitter PathPropagation::emitter(std::size_t source, const PropagationFrame& frame) const {
    return {sources_[source].id, frame.input.sources[source], false, frame.directivities[source]};
}

/// Traces all batches, then collects the arrivals on their segments, whose detection spheres depend
/// on all batches of a source.
void PathPropagation::trace(const PropagationFrame& frame) {
    std::vector<Receiver> receivers;
    for (const Vec3& listener : frame.input.listeners) {
        receivers.push_back(make_receiver(scene_, listener, listener_radius_m_));
    }
    const auto batch_count = static_cast<std::size_t>(tracer_.batch_count());
    workers_.run(sources_.size() * batch_count, [&](std::size_t job) {
        const std::size_t source = job / batch_count;
        const std::size_t b = job % batch_count;
        ArrivalBatch& batch = sources_[source].batches[b];
        batch.clear();
        tracer_.trace(emitter(source, frame), receivers, frame.seed, static_cast<int>(b), batch);
    });
    for (TracedSource& source : sources_) size_spheres(std::span(source.batches));
    workers_.run(sources_.size() * batch_count, [&](std::size_t job) {
        collect_segment_arrivals(scene_, receivers, attenuation_per_m_, ray_count(),
                                 sources_[job / batch_count].batches[job % batch_count]);
    });
}

void PathPropagation::step(const PropagationFrame& frame, std::span<const FramePair> pairs,
                           FrameStatistics& statistics) {
    Stopwatch watch;
    trace(frame);
    statistics.trace_s += watch.lap_s();
    for (std::size_t s = 0; s < sources_.size(); ++s) {
        std::vector<std::vector<Arrival>> at(listener_count_);
        for (const ArrivalBatch& batch : sources_[s].batches) {
            statistics.segments += batch.segment_count;
            for (const Arrival& arrival : batch.arrivals) at[arrival.receiver].push_back(arrival);
        }
        for (std::size_t l = 0; l < listener_count_; ++l) {
            Pair& pair = pairs[s * listener_count_ + l].pair;
            pair.response.clear_bins();
            if (!readout_) {
                add_arrivals(at[l], ray_count(), pair.images, pair.response);
                statistics.memory_bytes += at[l].capacity() * sizeof(Arrival);
                continue;
            }
            DiffusePathCache& cache = sources_[s].caches[l];
            cache.add_frame(at[l], ray_count());
            cache.add_to(pair.images, pair.response);
            statistics.cache_entries += cache.size();
            statistics.memory_bytes += cache.memory_bytes();
        }
    }
    statistics.cache_s += watch.lap_s();
}

std::vector<Ray> PathPropagation::rays(const PropagationFrame& frame) const {
    std::vector<Ray> all;
    for (std::size_t s = 0; s < sources_.size(); ++s) {
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
