#include "engine/estimate/patch_propagation.h"

#include <algorithm>
#include <deque>
#include <functional>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include "engine/base/sampling.h"
#include "engine/base/stopwatch.h"
#include "engine/estimate/frame_view.h"
#include "engine/trace/detection_spheres.h"

namespace aula {

namespace {

enum class SeedPurpose : std::uint64_t { grid = 2, gather = 4 };

/// Gathers are traced together up to the rays of one: some receivers have few, and the hits of all
/// need much memory.
constexpr int kGatherRaysTogether = kMostGatherRays;

/// The parts in which the energy of each of `pairs` is summed: those of all are enough for several
/// threads, and each part has a response of its own.
std::size_t divisions(std::size_t pairs) {
    constexpr std::size_t kParts = DepositParts::kCount;
    return std::max<std::size_t>(kParts / pairs, 1);
}

using GatheredEnergies = std::map<std::size_t, GatheredEnergy>;

/// Sums the gathers of all pairs. Returns the number of time bins that were added.
std::uint64_t sum(GatheredEnergies& energies, WorkerPool& workers) {
    std::vector<std::pair<GatheredEnergy*, std::size_t>> parts;
    for (auto& [i, energy] : energies)
        for (std::size_t part = 0; part < energy.part_count(); ++part)
            parts.emplace_back(&energy, part);
    workers.run(parts.size(), [&](std::size_t job) { parts[job].first->sum(parts[job].second); });
    std::uint64_t bins = 0;
    for (const auto& [i, energy] : energies) bins += energy.summed_bins();
    return bins;
}

}  // namespace

PatchPropagation::PatchPropagation(const RayScene& scene, const SpecularPaths& images,
                                   const Simulation& simulation, const TraceSettings& trace,
                                   const TimeBins& bins, std::span<const Vec3> inside,
                                   std::size_t source_count, std::size_t listener_count,
                                   WorkerPool& workers)
    : scene_(scene),
      workers_(workers),
      bins_(bins),
      window_frames_(simulation.window_frames()),
      listener_radius_m_(simulation.listener_radius_m),
      speed_of_sound_m_s_(trace.speed_of_sound_m_s),
      memory_bytes_(simulation.memory_mb * 1e6),
      listener_count_(listener_count),
      grid_(scene, simulation.patch_size_m, inside, derive_seed(simulation.seed, SeedPurpose::grid),
            workers, max_rows(memory_bytes_, bins_, source_count, listener_count)),
      tracer_(scene, grid_, bins_, images, trace),
      row_pool_(std::make_shared<RowPool>(bins.count())) {
    rays_may_mirror_ = simulation.specular || simulation.order > 0;
    find_mirrors();
    // A patch does not store the order of its energy: under a limit the tracer finds the paths that
    // end in a mirror.
    gather_settings_.mirrors = simulation.order == 0;
    gather_settings_.max_length_m = trace.max_length_m;
    gather_settings_.attenuation_per_m = trace.attenuation_per_m;
    for (std::size_t id = 0; id < source_count + listener_count; ++id)
        ends_.push_back(make_end(id, id >= source_count));
    divide_segments();
    // The rows of a source and of a listener. The first frame fills one of the caches, and the
    // first frame after a movement may fill the other.
    row_pool_->reserve(2 * grid_.reached_rows(), grid_.reached_rows(),
                       std::numeric_limits<std::size_t>::max());
}

void PatchPropagation::scene_moved() {
    grid_.scene_moved();
    clear_caches();
    resting_.clear();
}

/// Removes the energy of all emitters after a change of the grid, whose rows may belong to other
/// patches now: a movement can be too small to change the sum of all movements.
void PatchPropagation::clear_caches() {
    for (End& end : ends_) end.cache.clear();
}

void PatchPropagation::materials_changed() {
    find_mirrors();
    grid_.materials_changed();
    clear_caches();
}

/// Decides whether paths that end in a mirror are left to the rays.
void PatchPropagation::find_mirrors() {
    mirrors_ = rays_may_mirror_ &&
               std::any_of(scene_.triangles().begin(), scene_.triangles().end(),
                           [&](const RayScene::Triangle& t) {
                               return complement(scene_.material(t).scattering).max() > 0;
                           });
}

void PatchPropagation::restart() {
    for (End& end : ends_) end = make_end(end.id, end.cache.directed());
    divide_segments();
    last_move_.reset();
}

void PatchPropagation::add_source(std::size_t id, const Vec3& position,
                                  const OrientedDirectivity& directivity) {
    const auto index = static_cast<std::ptrdiff_t>(source_count());
    End& source = *ends_.insert(ends_.begin() + index, make_end(id, false));
    if (ends_.back().state) {
        source.state = {0, position, travel_m_};
        source.directivity = directivity;
        source.receiver = make_receiver(scene_, position, listener_radius_m_);
    }
    divide_segments();
}

void PatchPropagation::remove_source(std::size_t source) {
    ends_.erase(ends_.begin() + static_cast<std::ptrdiff_t>(source));
    divide_segments();
}

Emitter PatchPropagation::emitter(std::size_t e, const PropagationFrame& frame) const {
    if (e < source_count())
        return {ends_[e].id, frame.input.sources[e], false, frame.directivities[e]};
    return {ends_[e].id, frame.input.listeners[e - source_count()], true};
}

/// Removes what is invalid since the last frame.
void PatchPropagation::advance(const PropagationFrame& frame) {
    const bool scene_moved = frame.travel_m != travel_m_;
    if (scene_moved) last_move_ = frame.number;
    travel_m_ = frame.travel_m;
    std::vector<double> moved_m(emitter_count(), 0);
    for (std::size_t i = 0; i < emitter_count(); ++i) {
        End& end = ends_[i];
        double travel_m = frame.travel_m;
        // A source that turns counts as moved: rays of listeners do not depend on its orientation.
        if (i < source_count()) {
            if (end.state) end.turned_m += frame.directivities[i].turned_m(end.directivity);
            travel_m += end.turned_m;
            end.directivity = frame.directivities[i];
        }
        const SegmentCache::State now{frame.number, emitter(i, frame).position, travel_m};
        end.status.changed = end.state && now.changed_since(*end.state);
        if (end.state) moved_m[i] = now.moved_m(*end.state);
        if (end.status.changed) end.cache.clear();
        end.segments.advance(now);
        // Rays are also needed for paths that no gather finds.
        end.status.complete = end.cache.complete() && (!mirrors_ || end.segments.full());
        end.status.emitted_rays = end.cache.emitted();
        // Only paths that end in a mirror use the visible share of a receiver's spheres.
        if (!mirrors_) end.receiver = {now.emitter, listener_radius_m_};
        if (mirrors_ && (!end.state || end.status.changed))
            end.receiver = make_receiver(scene_, now.emitter, listener_radius_m_);
        end.state = now;
    }
    for (std::size_t s = 0; s < source_count(); ++s)
        for (std::size_t l = 0; l < listener_count_; ++l)
            ends_[s].pairs[l].begin_frame(moved_m[s] + moved_m[source_count() + l]);
}

/// Number of batches that each emitter traces.
std::vector<int> PatchPropagation::plan_batches(std::span<const EmitterStatus> status,
                                                std::uint64_t frame) const {
    std::vector<EmitterStatus> sources(
        status.begin(), status.begin() + static_cast<std::ptrdiff_t>(source_count()));
    // The plan prefers listeners to sources that move.
    if (from_listeners_)
        for (EmitterStatus& source : sources) source.changed = true;
    const std::vector<PairStatus> pairs = pair_status();
    const bool turn_of_listeners =
        frame % kReserveTurn == 0 &&
        std::all_of(pairs.begin(), pairs.end(), [](const PairStatus& p) { return p.at_rest; });
    const EmissionPlan plan =
        plan_emission(sources, status.subspan(source_count()), turn_of_listeners,
                      tracer_.batch_count(), tracer_.rays_of(1));
    std::vector<int> batches = plan.sources;
    batches.insert(batches.end(), plan.listeners.begin(), plan.listeners.end());
    return batches;
}

void PatchPropagation::trace(const PropagationFrame& frame, const std::vector<int>& batches,
                             FrameStatistics& statistics) {
    std::vector<std::pair<std::size_t, int>> jobs;
    for (std::size_t e = 0; e < emitter_count(); ++e)
        for (int b = 0; b < batches[e]; ++b) jobs.emplace_back(e, b);
    const auto kept = static_cast<std::size_t>(kSharedEmitters * tracer_.batch_count());
    batches_.resize(std::max(jobs.size(), std::min(batches_.size(), kept)));
    workers_.run(jobs.size(), [&](std::size_t job) {
        const auto [e, b] = jobs[job];
        batches_[job].clear();
        tracer_.trace(emitter(e, frame), frame.seed, b, batches_[job]);
    });
    for (const DepositBatch& batch : std::span(batches_).first(jobs.size()))
        statistics.segments += batch.segment_count;
}

/// Adds the traced batches to patch and segment caches.
void PatchPropagation::update(const std::vector<int>& batches) {
    std::vector<std::function<void()>> jobs;
    std::span<DepositBatch> left(batches_);
    for (std::size_t e = 0; e < emitter_count(); ++e) {
        if (batches[e] == 0) continue;
        const auto count = static_cast<std::size_t>(batches[e]);
        const std::span<DepositBatch> traced = left.first(count);
        left = left.subspan(count);
        const int rays = tracer_.rays_of(batches[e]);
        jobs.emplace_back([this, e, traced, rays] {
            size_spheres(traced);
            ends_[e].segments.add(traced, rays);
        });
        PatchCache& cache = ends_[e].cache;
        if (cache.complete()) continue;
        cache.begin_add(rays, grid_.size());
        for (std::size_t part = 0; part < DepositParts::kCount; ++part)
            jobs.emplace_back([&cache, traced, part] { cache.add_part(traced, part); });
    }
    workers_.run(jobs);
}

/// The status of each emitter.
std::vector<EmitterStatus> PatchPropagation::status() const {
    std::vector<EmitterStatus> status;
    for (const End& end : ends_) status.push_back(end.status);
    return status;
}

/// Number of rays in each cache.
std::vector<std::uint64_t> PatchPropagation::emitted() const {
    std::vector<std::uint64_t> rays;
    for (const End& end : ends_) rays.push_back(end.cache.emitted());
    return rays;
}

/// Each pair of source and listener, as input to the plan of the gathers.
std::vector<PairStatus> PatchPropagation::pair_status() const {
    std::vector<PairStatus> pairs;
    for (std::size_t s = 0; s < source_count(); ++s) {
        for (std::size_t l = 0; l < listener_count_; ++l) {
            const PairResponse& pair = ends_[s].pairs[l];
            pairs.push_back({s, source_count() + l, pair.frames(), pair.holds(window_frames_),
                             ends_[s].status.changed && pair.frames() >= window_frames_});
        }
    }
    return pairs;
}

/// True if the scene has moved within the last window of frames.
bool PatchPropagation::scene_moved_recently(std::uint64_t frame) const {
    return last_move_ && frame - *last_move_ < static_cast<std::uint64_t>(window_frames_);
}

GatherPlan PatchPropagation::plan_gather(std::uint64_t frame, std::span<const char> wanted,
                                         std::span<const std::uint64_t> emitted) const {
    std::size_t in_motion = 0;
    for (std::size_t e = 0; e < emitter_count(); ++e)
        if (ends_[e].status.changed && emitted[e] > 0) ++in_motion;
    return aula::plan_gather(pair_status(), wanted, emitted, tracer_.rays_of(tracer_.batch_count()),
                             scene_moved_recently(frame), in_motion);
}

GatherSettings PatchPropagation::gather_settings(int rays) const {
    GatherSettings settings = gather_settings_;
    settings.rays = rays;
    return settings;
}

std::uint64_t PatchPropagation::gather_seed(const PropagationFrame& frame,
                                            std::size_t receiver) const {
    return derive_seed(frame.seed, SeedPurpose::gather, receiver);
}

void PatchPropagation::gather(const PropagationFrame& frame, std::span<const FramePair> pairs,
                              FrameStatistics& statistics) {
    const std::vector<char> wanted = pairs_to_gather(pair_status(), frame.number);
    const GatherPlan plan = plan_gather(frame.number, wanted, emitted());
    for (std::size_t i = 0; i < pairs.size(); ++i) {
        if (wanted[i]) response_of(i).begin_gather();
    }
    std::vector<std::function<void()>> jobs;
    for (std::size_t i = 0; mirrors_ && i < pairs.size(); ++i)
        jobs.emplace_back([this, i] { detect(i); });
    for (std::size_t first = 0, end = 0; first < emitter_count(); first = end) {
        int rays = plan.at[end++].rays;
        while (end < emitter_count() && rays + plan.at[end].rays <= kGatherRaysTogether)
            rays += plan.at[end++].rays;
        gather_at_receivers(first, end, frame, plan, std::exchange(jobs, {}), statistics);
    }
    workers_.run(pairs.size(),
                 [&](std::size_t i) { complete_pair(i, wanted[i] != 0, pairs[i].pair); });
}

/// The gathers at the emitters [first, end). Other `jobs` are done with the tracing.
void PatchPropagation::gather_at_receivers(std::size_t first, std::size_t end,
                                           const PropagationFrame& frame, const GatherPlan& plan,
                                           std::vector<std::function<void()>> jobs,
                                           FrameStatistics& statistics) {
    std::deque<FinalGather> gathers;
    GatheredEnergies energies;
    std::set<std::size_t> gathered;
    for (std::size_t e = first; e < end; ++e)
        gathered.insert(plan.at[e].pairs.begin(), plan.at[e].pairs.end());
    for (std::size_t e = first; e < end; ++e) {
        if (plan.at[e].pairs.empty()) continue;
        const Emitter receiver = emitter(e, frame);
        FinalGather& gather = gathers.emplace_back(
            scene_, grid_, receiver, gather_settings(plan.at[e].rays), gather_seed(frame, e));
        for (std::size_t batch = 0; batch < gather.batch_count(); ++batch)
            jobs.emplace_back([&gather, batch] { gather.trace(batch); });
        for (const std::size_t i : plan.at[e].pairs) {
            const auto [source, listener] = ends_of(i);
            const GatherPlan::Shares& shares = plan.shares[i];
            GatheredEnergy& energy =
                energies.try_emplace(i, response_of(i).gathered(), divisions(gathered.size()))
                    .first->second;
            energy.add(gather.hits(), ends_[receiver.is_listener ? source : listener].cache,
                       receiver.is_listener ? shares.source : shares.listener);
        }
    }
    workers_.run(jobs);
    for (const FinalGather& gather : gathers) statistics.segments += gather.segments();
    statistics.summed_bins += sum(energies, workers_);
}

/// Detects the segments of a pair's ends.
void PatchPropagation::detect(std::size_t i) {
    const End& source = ends_[ends_of(i).source];
    const End& listener = ends_[ends_of(i).listener];
    response_of(i).detect(scene_, source.segments, listener.receiver, listener.segments,
                          source.receiver, source.directivity);
}

/// Updates a pair's response: the gathered energy and the segments whose paths no image source
/// counts now.
void PatchPropagation::complete_pair(std::size_t i, bool gathered, Pair& pair) {
    PairResponse& mean = response_of(i);
    const auto [source, listener] = ends_of(i);
    if (gathered) mean.end_gather(ends_[source].cache.emitted() + ends_[listener].cache.emitted());
    if (!gathered && !mirrors_) return;
    pair.response.energy = mean.response().energy;
    pair.response.directions = mean.response().directions;
    if (mirrors_) mean.add_detected_to(pair.images, pair.response);
}

void PatchPropagation::step(const PropagationFrame& frame, std::span<const FramePair> pairs,
                            FrameStatistics& statistics) {
    Stopwatch watch;
    advance(frame);
    statistics.cache_s += watch.lap_s();
    const std::vector<int> batches = plan_batches(status(), frame.number);
    trace(frame, batches, statistics);
    statistics.trace_s += watch.lap_s();
    update(batches);
    statistics.cache_s += watch.lap_s();

    gather(frame, pairs, statistics);
    statistics.gather_s += watch.lap_s();

    reserve_rows(frame.number);
    statistics.cache_s += watch.lap_s();

    for (const End& end : ends_) {
        statistics.cache_entries += end.cache.allocated_rows();
        statistics.memory_bytes += end.cache.memory_bytes() + end.segments.memory_bytes();
    }
    statistics.memory_bytes += row_pool_->free_bytes();
}

/// The sources' caches serve all receivers, which therefore need no caches.
void PatchPropagation::gather_at(const PropagationFrame& frame, std::span<const FramePair> pairs,
                                 FrameStatistics& statistics) {
    const std::vector<Vec3>& at = frame.input.listeners;
    resting_.resize(at.size());
    for (std::size_t r = 0; mirrors_ && r < at.size(); ++r) {
        if (!resting_[r] || resting_[r]->position != at[r]) {
            resting_[r] = make_receiver(scene_, at[r], listener_radius_m_);
        }
    }
    const int rays = gather_rays_of_receiver(tracer_.rays_of(tracer_.batch_count()),
                                             scene_moved_recently(frame.number));
    for (std::size_t r = 0; r < at.size(); ++r) {
        const Emitter receiver{emitter_count() + r, at[r], true};
        FinalGather gather(scene_, grid_, receiver, gather_settings(rays),
                           gather_seed(frame, emitter_count() + r));
        workers_.run(gather.batch_count(), [&](std::size_t batch) { gather.trace(batch); });
        GatheredEnergies energies;
        for (std::size_t s = 0; s < source_count(); ++s) {
            EnergyResponse& response = pairs[s * at.size() + r].pair.response;
            const auto added = energies.try_emplace(s, response, divisions(source_count())).first;
            added->second.add(gather.hits(), ends_[s].cache, 1);
        }
        statistics.segments += gather.segments();
        statistics.summed_bins += sum(energies, workers_);
    }
    if (!mirrors_) return;
    workers_.run(pairs.size(), [&](std::size_t i) {
        const SegmentCache& of_source = ends_[i / at.size()].segments;
        SpecularSum detected(EnergyResponse::silent(bins_, speed_of_sound_m_s_));
        of_source.add_to(scene_, *resting_[i % at.size()], {}, false, of_source.rays(), detected);
        detected.add_to(pairs[i].pair.images, pairs[i].pair.response);
    });
}

std::vector<PathLine> PatchPropagation::path_lines(const PropagationFrame& frame,
                                                   std::size_t source, int count, int order) const {
    return tracer_.lines(emitter(source, frame), frame.seed, count, order);
}

std::vector<PatchEnergy> PatchPropagation::patch_energies(std::size_t source, double begin_s,
                                                          double end_s) const {
    const bool sends = ends_[source].cache.emitted() > 0;
    return aula::patch_energies(grid_, ends_[sends ? source : source_count()].cache, bins_, begin_s,
                                end_s);
}

std::vector<Ray> PatchPropagation::rays(const PropagationFrame& frame) const {
    std::vector<Ray> all;
    const auto append = [&](const std::vector<Ray>& more) {
        all.insert(all.end(), more.begin(), more.end());
    };
    std::vector<std::uint64_t> rays_held = emitted();
    std::vector<EmitterStatus> unchanged(emitter_count());
    for (std::size_t e = 0; e < emitter_count(); ++e) {
        unchanged[e] = {false, ends_[e].cache.complete(), rays_held[e]};
    }
    const std::vector<int> batches = plan_batches(unchanged, frame.number);
    for (std::size_t e = 0; e < emitter_count(); ++e) {
        for (int b = 0; b < batches[e]; ++b) {
            append(tracer_.rays(emitter(e, frame), frame.seed, b));
        }
        rays_held[e] += static_cast<std::uint64_t>(tracer_.rays_of(batches[e]));
    }
    const GatherPlan plan =
        plan_gather(frame.number, pairs_to_gather(pair_status(), frame.number), rays_held);
    for (std::size_t e = 0; e < emitter_count(); ++e) {
        if (plan.at[e].pairs.empty()) continue;
        append(FinalGather(scene_, grid_, emitter(e, frame), gather_settings(plan.at[e].rays),
                           gather_seed(frame, e))
                   .rays());
    }
    return all;
}

}  // namespace aula
