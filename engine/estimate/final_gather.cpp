#include "engine/estimate/final_gather.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "engine/base/air_attenuation.h"
#include "engine/base/sampling.h"
#include "engine/rays/wall_crossing.h"
#include "engine/trace/resampling.h"

namespace aula {

namespace {

constexpr int kBatchRays = 128;

/// Russian roulette applies to a mirror ray below this weight in every band.
constexpr float kRouletteWeight = 0.7F;

/// From this time on, where the sound field is diffuse, the first kLateShare of the rays represents
/// all. A prefix of a low-discrepancy sequence is itself evenly distributed.
constexpr double kLate_s = 0.512;
constexpr float kLateShare = 0.25F;

/// Hits of a patch whose lengths differ by less than this share of the patch size are merged: the
/// radiated energy has no finer resolution.
constexpr float kJoined = 0.5F;

/// Seeds the survival of the rays behind walls, beside the generations of the resampling.
constexpr std::uint64_t kRoulette = 100;

struct MirrorRay {
    Ray ray;
    Vec3 first_direction{0};
    Bands weight = Bands::filled(1);
    float roulette_weight = kRouletteWeight;
    float length_m = 0;
    std::uint32_t crossings = 0;  ///< walls passed
    bool late = false;
    RandomStream random;
};

/// Rays of a batch that have just left a surface.
struct Departures {
    std::vector<MirrorRay> rays;      ///< of those that have passed no wall
    std::vector<MirrorRay> behind;    ///< of those that have
    std::vector<WallEntry> entries;   ///< where rays meet walls that transmit
    std::vector<MirrorRay> entering;  ///< [entry] with the weight at the wall
    std::vector<WallExit> exits;      ///< [entry]
    Resampler resampler;
    Thinning thinning;

    void clear() {
        rays.clear();
        behind.clear();
        entries.clear();
        entering.clear();
    }
};

/// Continues rays straight on through walls. Their number is limited as that of emitted paths.
void pass_walls(const RayScene& scene, float max_length_m, std::uint64_t seed,
                Departures& departures) {
    if (departures.entries.empty()) return;
    find_wall_exits(scene, departures.entries, departures.exits);
    std::vector<MirrorRay>& behind = departures.behind;
    for (std::size_t i = 0; i < departures.exits.size(); ++i) {
        const WallExit& exit = departures.exits[i];
        MirrorRay r = departures.entering[i];
        const Bands share = exit.wall.transmission * complement(exit.wall.scattering);
        r.weight *= share;
        if (!(r.weight.max() > 0)) continue;
        r.roulette_weight *= share.max();
        r.length_m += exit.thickness_m;
        ++r.crossings;
        Vec3 onward = r.ray.direction;
        if (glm::dot(onward, exit.normal) <= 0) onward = mirror(onward, exit.normal);
        r.ray = {exit.point, onward, max_length_m - r.length_m};
        r.random = RandomStream(derive_seed(r.random.state(), r.crossings));
        behind.push_back(r);
    }
    std::vector<Bands> weights;
    std::vector<std::uint32_t> crossings;
    for (const MirrorRay& r : behind) {
        weights.push_back(r.weight);
        crossings.push_back(r.crossings);
    }
    double energy = 0;
    for (const Bands& of_ray : weights) energy += double{of_ray.sum()};
    Thinning& thinning = departures.thinning;
    const float factor =
        thinning.next(energy, double{RandomStream(derive_seed(seed, kRoulette)).uniform()});
    std::vector<MirrorRay> kept;
    if (factor > 0) {
        for (const Resampler::Survivor& survivor :
             departures.resampler.choose(weights, crossings, thinning.places(), seed)) {
            kept.push_back(behind[survivor.index]);
            kept.back().weight *= factor * survivor.factor;
        }
    }
    behind = std::move(kept);
}

/// Adds the energy that arrives by one hit, times `scale`. Returns the number of bins added.
std::uint64_t add_hit(const GatherHit& hit, const PatchCache& cache, std::size_t late_bin,
                      double delay_s, float scale, ShiftedHistogram& sum) {
    if (hit.patch >= cache.row_count()) return 0;
    const PatchCache::Row& row = cache.row(hit.patch);
    if (!row.sum) return 0;
    const TimeHistogram radiated{row.sum, row.directions, row.total};
    const Bands weight = hit.weight * scale;
    std::uint64_t bins = 0;
    const auto add = [&](std::size_t first, std::size_t end, float factor) {
        if (first >= end) return;
        sum.add(radiated, first, end, delay_s, weight * factor, hit.directions);
        bins += end - first;
    };
    add(row.first_bin, std::min<std::size_t>(row.end_bin, late_bin), 1);
    if (hit.late) add(std::max<std::size_t>(row.first_bin, late_bin), row.end_bin, 1 / kLateShare);
    return bins;
}

/// Merges another hit of the same patch by the weighted mean of their lengths and directions.
void join(GatherHit& all, const GatherHit& hit) {
    const float more = hit.weight.sum();
    all.weight += hit.weight;
    if (more == 0) return;
    const float share = more / all.weight.sum();
    all.length_m += share * (hit.length_m - all.length_m);
    all.directions = all.directions * (1 - share) + hit.directions * share;
}

/// Sorts hits by patch, late ones first, and merges those of about the same length.
template <typename Batch>
std::vector<GatherHit> joined_by_patch(const std::vector<Batch>& batches, std::size_t patch_count,
                                       float patch_size_m) {
    // Counting sort.
    std::vector<std::size_t> next(2 * patch_count + 1, 0);
    const auto slot = [](const GatherHit& hit) { return 2 * hit.patch + (hit.late ? 0U : 1U); };
    for (const Batch& batch : batches) {
        for (const GatherHit& hit : batch.hits) ++next[slot(hit) + 1];
    }
    for (std::size_t i = 1; i < next.size(); ++i) next[i] += next[i - 1];
    std::vector<const GatherHit*> ordered(next.back());
    for (const Batch& batch : batches) {
        for (const GatherHit& hit : batch.hits) ordered[next[slot(hit)]++] = &hit;
    }

    std::vector<GatherHit> joined;
    joined.reserve(ordered.size());
    std::size_t first = 0;        // of the same patch and kind
    std::vector<float> length_m;  // [merged hit] length of its first hit
    for (const GatherHit* hit : ordered) {
        if (first == joined.size() || slot(joined[first]) != slot(*hit)) {
            first = joined.size();
            length_m.clear();
        }
        std::size_t k = 0;
        while (k < length_m.size() &&
               std::abs(length_m[k] - hit->length_m) > kJoined * patch_size_m)
            ++k;
        if (k < length_m.size()) {
            join(joined[first + k], *hit);
        } else {
            joined.push_back(*hit);
            length_m.push_back(hit->length_m);
        }
    }
    return joined;
}

}  // namespace

FinalGather::FinalGather(const RayScene& scene, const PatchGrid& grid, const Emitter& receiver,
                         const GatherSettings& settings, std::uint64_t frame_seed)
    : scene_(scene),
      grid_(grid),
      receiver_(receiver),
      settings_(settings),
      frame_seed_(frame_seed),
      batches_(static_cast<std::size_t>((settings.rays + kBatchRays - 1) / kBatchRays)),
      batches_left_(batches_.size()) {}

void FinalGather::trace(std::size_t batch) {
    Batch& traced = batches_[batch];
    trace(batch, traced.hits,
          [&](const std::vector<Ray>& rays) { traced.segments += rays.size(); });
    if (--batches_left_ > 0) return;
    hits_ = joined_by_patch(batches_, grid_.size(), grid_.patch_size_m());
    for (Batch& joined : batches_) joined.hits = {};
}

/// Traces a batch reflection by reflection; the lanes hold the next segment of every ray. `sent` is
/// called with each set of lanes.
template <typename Sent>
void FinalGather::trace(std::size_t batch, std::vector<GatherHit>& out, const Sent& sent) const {
    const ScrambledSobol sobol(derive_seed(frame_seed_, 1));
    std::vector<MirrorRay> rays;
    rays.reserve(kBatchRays);
    const int first = static_cast<int>(batch) * kBatchRays;
    for (int i = first; i < std::min(first + kBatchRays, settings_.rays); ++i) {
        MirrorRay r;
        std::tie(r.first_direction, r.weight) =
            receiver_.directivity.sample(sobol.point(static_cast<std::uint32_t>(i)));
        r.ray = {receiver_.position, r.first_direction, settings_.max_length_m};
        r.random = RandomStream(derive_seed(frame_seed_, 2, i));
        r.late = static_cast<float>(i) < kLateShare * static_cast<float>(settings_.rays);
        rays.push_back(r);
    }
    std::vector<Ray> queries;
    std::vector<Hit> hits;
    Departures next;
    next.rays.reserve(kBatchRays);
    for (std::uint64_t reflections = 0; !rays.empty(); ++reflections) {
        queries.clear();
        for (const MirrorRay& r : rays) queries.push_back(r.ray);
        hits.resize(rays.size());
        scene_.intersect(queries, hits);
        sent(queries);
        next.clear();
        for (std::size_t i = 0; i < rays.size(); ++i) {
            if (!hits[i].any()) continue;
            MirrorRay r = rays[i];
            const Vec3 direction = r.ray.direction;
            const Vec3 normal = scene_.facing_normal(hits[i], direction);
            const float cosine = -glm::dot(direction, normal);
            const RayScene::PointOff at = RayScene::point_off(hits[i].distance_m, cosine);
            const Vec3 point = r.ray.origin + at.along_m * direction + at.off_m * normal;
            const std::uint32_t index = scene_.surface(hits[i].triangle).material;
            const Material& material = scene_.material(index);
            r.length_m += hits[i].distance_m;
            r.weight *= transmission(settings_.attenuation_per_m, hits[i].distance_m);
            // Mirrors count as well where they share a patch with a scattering surface.
            const PatchGrid::Radiator radiator =
                grid_.find_radiator(hits[i].triangle, point, normal);
            if (radiator.row != PatchGrid::kNone) {
                // A patch of area A that radiates B by Lambert's law has the radiance B / (pi A).
                // Fluence is radiance times solid angle, 4 pi / M for each of M rays:
                // 4 pi / M * B / (pi A) = 4 / (M A) * B.
                const float factor = 4 / static_cast<float>(settings_.rays) * radiator.per_m2;
                out.push_back({radiator.row, r.length_m, DirectionMoments::of(r.first_direction),
                               r.weight * factor, r.late});
            }
            if (!settings_.mirrors) continue;
            if (scene_.transmits(index)) {
                const RayScene::PointOff beyond =
                    RayScene::point_beyond(hits[i].distance_m, cosine);
                next.entries.push_back(
                    {hits[i], r.ray.origin + beyond.along_m * direction + beyond.off_m * normal,
                     normal});
                next.entering.push_back(r);
            }
            r.weight *= complement(material.scattering) * complement(material.absorption);
            const float strongest = r.weight.max();
            if (!(strongest > 0)) continue;
            if (strongest < r.roulette_weight) {
                const float survival = strongest / r.roulette_weight;
                if (!(r.random.uniform() < survival)) continue;
                r.weight *= 1 / survival;
            }
            r.ray = {point, mirror(direction, normal), settings_.max_length_m - r.length_m};
            (r.crossings > 0 ? next.behind : next.rays).push_back(r);
        }
        pass_walls(scene_, settings_.max_length_m, derive_seed(frame_seed_, 3, batch, reflections),
                   next);
        rays.swap(next.rays);
        rays.insert(rays.end(), next.behind.begin(), next.behind.end());
    }
}

std::uint64_t FinalGather::segments() const {
    std::uint64_t all = 0;
    for (const Batch& batch : batches_) all += batch.segments;
    return all;
}

std::vector<Ray> FinalGather::rays() const {
    std::vector<Ray> all;
    std::vector<GatherHit> unused;
    for (std::size_t i = 0; i < batch_count(); ++i) {
        trace(i, unused, [&](const std::vector<Ray>& sent) {
            all.insert(all.end(), sent.begin(), sent.end());
        });
    }
    return all;
}

void GatheredEnergy::add(const std::vector<GatherHit>& hits, const PatchCache& cache,
                         double share) {
    if (cache.emitted() == 0) return;
    gathers_.push_back(
        {hits, cache, static_cast<float>(share / static_cast<double>(cache.emitted()))});
    parts_.resize(gathers_.size() * divisions_);
}

void GatheredEnergy::sum(std::size_t part) {
    const auto& [hits, cache, scale] = gathers_[part / divisions_];
    const TimeBins& bins = response_.bins;
    const std::size_t late_bin = bins.index(kLate_s);
    const std::size_t chunk = part % divisions_;
    ShiftedHistogram& sum = parts_[part].emplace(bins);
    std::uint64_t bin_count = 0;
    for (std::size_t i = hits.size() * chunk / divisions_;
         i < hits.size() * (chunk + 1) / divisions_; ++i) {
        const double delay_s = double{hits[i].length_m} / double{response_.speed_of_sound_m_s};
        bin_count += add_hit(hits[i], cache, late_bin, delay_s, scale, sum);
    }
    summed_bins_ += bin_count;
    if (++parts_summed_ < part_count()) return;
    for (std::size_t g = 0; g < gathers_.size(); ++g) {
        for (std::size_t k = 0; k < bins.count(); ++k) {
            Bands energy;
            DirectionMoments directions;
            for (std::size_t p = g * divisions_; p < (g + 1) * divisions_; ++p) {
                energy += parts_[p]->energy(k);
                directions += parts_[p]->directions(k);
            }
            // Directions are weighted by a row's whole spectrum, which may differ from that of a
            // bin.
            const float length = glm::length(directions.intensity);
            if (length > energy.sum()) directions *= energy.sum() / length;
            response_.energy[k] += energy;
            response_.directions[k] += directions;
        }
    }
    for (auto& summed : parts_) summed.reset();
}

}  // namespace aula
