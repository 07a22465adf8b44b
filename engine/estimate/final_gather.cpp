#include "engine/estimate/final_gather.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "engine/base/air_attenuation.h"
#include "engine/base/sampling.h"
#include "engine/rays/follow_rays.h"
#include "engine/rays/wall_crossing.h"
#include "engine/trace/resampling.h"

namespace aula {

namespace {

/// Russian roulette applies to a mirror ray below this weight in every band. A choice: between
/// mirrors half of it has 1 % less noise and takes a tenth more time, 1.4 times it a fifth more
/// noise (`aula-bench noise --estimator patch --rays 1000 scenes/museum.json`).
constexpr float kRouletteWeight = 0.7F;

/// From this time on, where the sound field is diffuse, the first kLateShare of the rays represents
/// all. A prefix of a low-discrepancy sequence is itself evenly distributed. Choices: bins are
/// eight times as wide there as the first ones, and late parts of rows are most of the sums of a
/// hall.
constexpr double kLate_s = 0.512;
constexpr float kLateShare = 0.25F;

/// Hits of a patch whose lengths differ by less than this share of the patch size are merged: the
/// radiated energy has no finer resolution, as a ray may meet the patch anywhere.
constexpr float kJoined = 0.5F;

/// Seeds the survival of the rays behind walls; the generations of the resampling have lower
/// numbers of the same seed.
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

/// Rays of a batch at walls that transmit. Their number is limited as that of emitted paths.
class WallPassages {
 public:
    /// Adds a ray with its weight at a wall.
    void enter(const MirrorRay& ray, const WallEntry& at) {
        rays_.push_back(ray);
        entries_.push_back(at);
    }

    /// Continues all rays straight on. `rays` ends with those that have passed walls before.
    void pass(const RayScene& scene, float max_length_m, std::uint64_t seed,
              std::vector<MirrorRay>& rays);

 private:
    std::vector<WallEntry> entries_;
    std::vector<MirrorRay> rays_;  ///< [entry]
    std::vector<WallExit> exits_;  ///< [entry]
    Resampler resampler_;
    Thinning thinning_;
};

void WallPassages::pass(const RayScene& scene, float max_length_m, std::uint64_t seed,
                        std::vector<MirrorRay>& rays) {
    if (entries_.empty()) return;
    const auto first =
        std::find_if(rays.begin(), rays.end(), [](const MirrorRay& r) { return r.crossings > 0; });
    std::vector<MirrorRay> behind(first, rays.end());
    rays.erase(first, rays.end());
    find_wall_exits(scene, entries_, exits_);
    for (std::size_t i = 0; i < exits_.size(); ++i) {
        const WallExit& exit = exits_[i];
        MirrorRay r = rays_[i];
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
    entries_.clear();
    rays_.clear();
    std::vector<Bands> weights;
    std::vector<std::uint32_t> crossings;
    double energy = 0;
    for (const MirrorRay& r : behind) {
        weights.push_back(r.weight);
        crossings.push_back(r.crossings);
        energy += double{r.weight.sum()};
    }
    const float factor =
        thinning_.next(energy, double{RandomStream(derive_seed(seed, kRoulette)).uniform()});
    if (!(factor > 0)) return;
    for (const Resampler::Survivor& survivor :
         resampler_.choose(weights, crossings, thinning_.places(), seed)) {
        rays.push_back(behind[survivor.index]);
        rays.back().weight *= factor * survivor.factor;
    }
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
    std::uint64_t segments = 0;
    trace(batch, traced.hits, [&](const Ray&) { ++segments; });
    traced.segments = segments;
    if (--batches_left_ > 0) return;
    hits_ = joined_by_patch(batches_, grid_.size(), grid_.patch_size_m());
    for (Batch& joined : batches_) joined.hits = {};
}

/// Traces a batch reflection by reflection. `sent` is called with each segment.
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
    WallPassages walls;
    const auto segment = [&](const MirrorRay& r) {
        sent(r.ray);
        return r.ray;
    };
    const auto meet = [&](MirrorRay& r, const Ray& ray, const Hit& hit) {
        if (!hit.any()) return false;
        const Vec3& direction = ray.direction;
        const Vec3 normal = scene_.facing_normal(hit, direction);
        const float cosine = -glm::dot(direction, normal);
        const RayScene::PointOff at = RayScene::point_off(hit.distance_m, cosine);
        const Vec3 point = ray.origin + at.along_m * direction + at.off_m * normal;
        const std::uint32_t index = scene_.surface(hit.triangle).material;
        const Material& material = scene_.material(index);
        r.length_m += hit.distance_m;
        r.weight *= transmission(settings_.attenuation_per_m, hit.distance_m);
        // Mirrors count as well where they share a patch with a scattering surface.
        const PatchGrid::Radiator radiator = grid_.find_radiator(hit.triangle, point, normal);
        if (radiator.row != PatchGrid::kNone) {
            // A patch of area A that radiates B by Lambert's law has the radiance B / (pi A).
            // Fluence is radiance times solid angle, 4 pi / M for each of M rays:
            // 4 pi / M * B / (pi A) = 4 / (M A) * B.
            const float factor = 4 / static_cast<float>(settings_.rays) * radiator.per_m2;
            out.push_back({radiator.row, r.length_m, DirectionMoments::of(r.first_direction),
                           r.weight * factor, r.late});
        }
        if (!settings_.mirrors) return false;
        if (scene_.transmits(index)) {
            const RayScene::PointOff beyond = RayScene::point_beyond(hit.distance_m, cosine);
            walls.enter(
                r, {hit, ray.origin + beyond.along_m * direction + beyond.off_m * normal, normal});
        }
        r.weight *= complement(material.scattering) * complement(material.absorption);
        const float strongest = r.weight.max();
        if (!(strongest > 0)) return false;
        if (strongest < r.roulette_weight) {
            const float survival = strongest / r.roulette_weight;
            if (!(r.random.uniform() < survival)) return false;
            r.weight *= 1 / survival;
        }
        r.ray = {point, mirror(direction, normal), settings_.max_length_m - r.length_m};
        return true;
    };
    std::uint64_t reflections = 0;
    follow_rays(scene_, rays, segment, meet, [&] {
        walls.pass(scene_, settings_.max_length_m, derive_seed(frame_seed_, 3, batch, reflections),
                   rays);
        ++reflections;
    });
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
        trace(i, unused, [&](const Ray& sent) { all.push_back(sent); });
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
