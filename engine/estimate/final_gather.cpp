#include "engine/estimate/final_gather.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>

#include "engine/base/air_attenuation.h"
#include "engine/base/band_vector.h"
#include "engine/base/multiversion.h"
#include "engine/base/sampling.h"

namespace aula {

namespace {

constexpr int kBatchRays = 128;
constexpr std::size_t kChunks = 8;  // of hits, each summed separately

/// Russian roulette applies to a mirror ray below this weight in every band.
constexpr float kRouletteWeight = 0.7F;

/// From this time on, where the sound field is diffuse, the first kLateShare of the rays represents
/// all. A prefix of a low-discrepancy sequence is itself evenly distributed.
constexpr double kLate_s = 0.512;
constexpr float kLateShare = 0.25F;

/// Hits of a patch whose lengths differ by less than this share of the patch size are merged: the
/// radiated energy has no finer resolution.
constexpr float kJoined = 0.5F;

constexpr std::size_t kPrefetchDistance = 32;  // bins of a row

struct MirrorRay {
    Ray ray;
    Vec3 first_direction{0};
    Bands weight = Bands::filled(1);
    float length_m = 0;
    bool late = false;
    RandomStream random;
};

std::size_t batch_count(const GatherSettings& settings) {
    return static_cast<std::size_t>((settings.rays + kBatchRays - 1) / kBatchRays);
}

/// Traces a batch reflection by reflection; the lanes hold the next segment of every ray. `sent` is
/// called with each set of lanes.
template <typename Sent>
void trace_batch(const RayScene& scene, const PatchGrid& grid, const Vec3& receiver,
                 const GatherSettings& settings, std::uint64_t frame_seed, int batch,
                 std::vector<GatherHit>& out, const Sent& sent) {
    const ScrambledSobol sobol(derive_seed(frame_seed, 1));
    std::vector<MirrorRay> rays;
    for (int i = batch * kBatchRays; i < std::min((batch + 1) * kBatchRays, settings.rays); ++i) {
        MirrorRay r;
        r.first_direction = uniform_direction(sobol.point(static_cast<std::uint32_t>(i)));
        r.ray = {receiver, r.first_direction, settings.max_length_m};
        r.random = RandomStream(derive_seed(frame_seed, 2, i));
        r.late = static_cast<float>(i) < kLateShare * static_cast<float>(settings.rays);
        rays.push_back(r);
    }
    std::vector<Ray> queries;
    std::vector<Hit> hits;
    std::vector<PatchGrid::Radiator> radiators;
    while (!rays.empty()) {
        queries.clear();
        for (const MirrorRay& r : rays) queries.push_back(r.ray);
        hits.resize(rays.size());
        scene.intersect(queries, hits);
        sent(queries);
        std::size_t alive = 0;
        for (std::size_t i = 0; i < rays.size(); ++i) {
            if (!hits[i].any()) continue;
            MirrorRay r = rays[i];
            const Vec3 direction = r.ray.direction;
            const Vec3 normal = scene.facing_normal(hits[i], direction);
            const RayScene::PointOff at =
                RayScene::point_off(hits[i].distance_m, -glm::dot(direction, normal));
            const Vec3 point = r.ray.origin + at.along_m * direction + at.off_m * normal;
            const Material& material = scene.material(scene.surface(hits[i].triangle).material);
            r.length_m += hits[i].distance_m;
            r.weight *= transmission(settings.attenuation_per_m, hits[i].distance_m);
            // Mirrors count as well where they share a patch with a scattering surface.
            grid.find_radiators(hits[i].triangle, point, normal, radiators);
            for (const PatchGrid::Radiator& radiator : radiators) {
                // A patch of area A that radiates B by Lambert's law has the radiance B / (pi A).
                // Fluence is radiance times solid angle, 4 pi / M for each of M rays:
                // 4 pi / M * B / (pi A) = 4 / (M A) * B.
                const float factor = 4 / static_cast<float>(settings.rays) * radiator.per_m2;
                out.push_back(
                    {radiator.row, r.length_m, r.first_direction, r.weight * factor, r.late});
            }
            if (!settings.mirrors) continue;
            r.weight *= complement(material.scattering) * complement(material.absorption);
            const float strongest = r.weight.max();
            if (!(strongest > 0)) continue;
            if (strongest < kRouletteWeight) {
                const float survival = strongest / kRouletteWeight;
                if (!(r.random.uniform() < survival)) continue;
                r.weight *= 1 / survival;
            }
            r.ray = {point, mirror(direction, normal), settings.max_length_m - r.length_m};
            rays[alive++] = r;
        }
        rays.resize(alive);
    }
}

/// Consecutive bins of equal width.
struct Region {
    std::size_t first_bin = 0;
    std::size_t end_bin = 0;
    float width_s = 0;
};

std::vector<Region> regions_of(const TimeBins& bins) {
    std::vector<Region> regions;
    for (std::size_t k = 0; k < bins.count(); ++k) {
        const auto width_s = static_cast<float>(bins.end_s(k) - bins.begin_s(k));
        if (regions.empty() || std::abs(regions.back().width_s - width_s) > 1e-6F) {
            regions.push_back({k, k, width_s});
        }
        regions.back().end_bin = k + 1;
    }
    return regions;
}

/// One patch's row as floats.
struct FloatRow {
    std::vector<float> energy;  // [bin][band]
    std::vector<float> sum;     // [bin], over bands
    std::vector<float> moment;  // [bin][4], for a listener's cache
    Bands total;
    std::size_t first_bin = 0;
    std::size_t end_bin = 0;
};

/// The contribution of a chunk of hits. One bin more than the response receives the overflow at its
/// end.
struct Partial {
    std::vector<float> energy;     // [bin][band]
    std::vector<float> direction;  // [bin][4]
};

/// Converts bins [first_bin, end_bin) of a row to floats, with their sums over bands; adds to
/// `total`.
AULA_MULTIVERSION
void convert_row(const std::int64_t* sums, std::size_t first_bin, std::size_t end_bin, double scale,
                 float* energy, float* sum, Bands& total) {
    BandVector all = load_bands(total);
    for (std::size_t k = first_bin; k < end_bin; ++k) {
        // Prefetch: rows are scattered in memory.
        __builtin_prefetch(sums + std::min(k + kPrefetchDistance, end_bin) * kBandCount);
        const BandVector e = to_bands(sums + k * kBandCount, scale);
        store_bands(e, energy + k * kBandCount);
        sum[k] = sum_of_bands(e)[0];
        all += e;
    }
    store_bands(all, total.value.data());
}

/// Converts bins [first_bin, end_bin) of moments to floats.
void convert_moments(const std::int64_t* moments, std::size_t first_bin, std::size_t end_bin,
                     double scale, float* moment) {
    for (std::size_t k = first_bin; k < end_bin; ++k) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            moment[k * 4 + axis] =
                static_cast<float>(static_cast<double>(moments[k * 3 + axis]) * scale);
        }
    }
}

/// Adds `count` bins of the output's width: each leaves the share `stays` in the output bin of its
/// number and the rest in the next.
inline void add_equal_bins(const float* in, std::size_t count, float stays, const float* weight,
                           float* out) {
    const BandVector keep = stays * load_bands(weight);
    const BandVector pass = (1 - stays) * load_bands(weight);
    BandVector passed{};
    for (std::size_t k = 0; k < count; ++k) {
        const BandVector here = load_bands(in + k * kBandCount);
        store_bands(load_bands(out + k * kBandCount) + keep * here + passed, out + k * kBandCount);
        passed = pass * here;
    }
    store_bands(load_bands(out + count * kBandCount) + passed, out + count * kBandCount);
}

/// As add_equal_bins, for one number per bin times the four components of a direction.
inline void add_equal_sums(const float* sum, std::size_t count, float stays, const float* direction,
                           float* out) {
    const FourVector keep = stays * load_four(direction);
    const FourVector pass = (1 - stays) * load_four(direction);
    FourVector passed{};
    for (std::size_t k = 0; k < count; ++k) {
        store_four(load_four(out + k * 4) + keep * sum[k] + passed, out + k * 4);
        passed = pass * sum[k];
    }
    store_four(load_four(out + count * 4) + passed, out + count * 4);
}

/// As add_equal_bins, for the three components of a direction and a fourth that is 0.
inline void add_equal_moments(const float* in, std::size_t count, float stays, const float* weight,
                              float* out) {
    const FourVector keep = stays * load_four(weight);
    const FourVector pass = (1 - stays) * load_four(weight);
    FourVector passed{};
    for (std::size_t k = 0; k < count; ++k) {
        const FourVector here = load_four(in + k * 4);
        store_four(load_four(out + k * 4) + keep * here + passed, out + k * 4);
        passed = pass * here;
    }
    store_four(load_four(out + count * 4) + passed, out + count * 4);
}

/// Adds bins [bin, end) of equal width until the output's width changes at out_end. The first
/// begins `x` output bins after the start of output bin `out`. An output bin is 1 / `ratio` times
/// as wide, `ratio` <= 1. `direction` multiplies the moments, if given, or else the sums. Energy is
/// uniform in time inside a bin: the part before the next output edge stays, the rest goes to the
/// next bin. Returns the bin after the last one added.
AULA_MULTIVERSION
std::size_t add_bins(const float* energy, const float* sum, const float* moment, std::size_t bin,
                     std::size_t end, float ratio, const float* weight, const float* direction,
                     float x, std::size_t out, std::size_t out_end, float* out_energy,
                     float* out_direction) {
    if (ratio > 0.999F) {
        const std::size_t count = std::min(end - bin, out_end - out);
        add_equal_bins(energy + bin * kBandCount, count, 1 - x, weight,
                       out_energy + out * kBandCount);
        if (moment) {
            add_equal_moments(moment + bin * 4, count, 1 - x, direction, out_direction + out * 4);
        } else {
            add_equal_sums(sum + bin, count, 1 - x, direction, out_direction + out * 4);
        }
        return bin + count;
    }
    const BandVector weights = load_bands(weight);
    const FourVector directions = load_four(direction);
    for (; bin < end && out < out_end; ++bin) {
        const float stays = std::min(1.0F, (1 - x) / ratio);
        const float goes = 1 - stays;
        const BandVector e = weights * load_bands(energy + bin * kBandCount);
        float* to = out_energy + out * kBandCount;
        store_bands(load_bands(to) + stays * e, to);
        store_bands(load_bands(to + kBandCount) + goes * e, to + kBandCount);
        const FourVector d =
            moment ? directions * load_four(moment + bin * 4) : directions * sum[bin];
        float* towards = out_direction + out * 4;
        store_four(load_four(towards) + stays * d, towards);
        store_four(load_four(towards + 4) + goes * d, towards + 4);
        x += ratio;
        if (x >= 1) {
            x -= 1;
            ++out;
        }
    }
    return bin;
}

/// Adds bins [first_bin, end_bin) of a row, multiplied by `factor` and delayed by `shift_s`.
void add_row(const FloatRow& row, std::size_t first_bin, std::size_t end_bin, float factor,
             const GatherHit& hit, const TimeBins& bins, const std::vector<Region>& regions,
             double shift_s, Partial& partial) {
    // The direction carries the energy of all bands: the mean weight over the row's own spectrum.
    const Bands weight = hit.weight * factor;
    float weighted = 0;
    for (std::size_t b = 0; b < kBandCount; ++b) weighted += weight[b] * row.total[b];
    const float mean_weight = weighted / row.total.sum();
    const bool directed = !row.moment.empty();
    const Vec3 mean = directed ? Vec3(mean_weight) : hit.direction * mean_weight;
    const std::array<float, 4> direction{mean.x, mean.y, mean.z, 0};
    for (const Region& in : regions) {
        std::size_t bin = std::max(first_bin, in.first_bin);
        const std::size_t end = std::min(end_bin, in.end_bin);
        while (bin < end) {
            const double begin_s = bins.begin_s(bin) + shift_s;
            const std::size_t out = bins.index(begin_s);
            if (out >= bins.count()) return;
            const auto region = std::find_if(regions.begin(), regions.end(),
                                             [&](const Region& r) { return out < r.end_bin; });
            const auto x =
                static_cast<float>((begin_s - bins.begin_s(out)) / double{region->width_s});
            bin = add_bins(row.energy.data(), row.sum.data(),
                           directed ? row.moment.data() : nullptr, bin, end,
                           in.width_s / region->width_s, weight.value.data(), direction.data(), x,
                           out, region->end_bin, partial.energy.data(), partial.direction.data());
        }
    }
}

/// Merges another hit of the same patch by the weighted mean of their lengths and directions.
void join(GatherHit& all, const GatherHit& hit) {
    const float more = hit.weight.sum();
    all.weight += hit.weight;
    if (more == 0) return;
    const float share = more / all.weight.sum();
    all.length_m += share * (hit.length_m - all.length_m);
    all.direction += share * (hit.direction - all.direction);
}

/// Sorts hits by patch, late ones first, and merges those of about the same length.
std::vector<GatherHit> joined_by_patch(const std::vector<std::vector<GatherHit>>& batches,
                                       std::size_t patch_count, float patch_size_m) {
    // Counting sort.
    std::vector<std::size_t> next(2 * patch_count + 1, 0);
    const auto place = [](const GatherHit& hit) { return 2 * hit.patch + (hit.late ? 0U : 1U); };
    for (const auto& batch : batches) {
        for (const GatherHit& hit : batch) ++next[place(hit) + 1];
    }
    for (std::size_t i = 1; i < next.size(); ++i) next[i] += next[i - 1];
    std::vector<const GatherHit*> ordered(next.back());
    for (const auto& batch : batches) {
        for (const GatherHit& hit : batch) ordered[next[place(hit)]++] = &hit;
    }

    std::vector<GatherHit> joined;
    joined.reserve(ordered.size());
    std::size_t first = 0;        // of the same patch and kind
    std::vector<float> length_m;  // [merged hit] length of its first hit
    for (const GatherHit* hit : ordered) {
        if (first == joined.size() || place(joined[first]) != place(*hit)) {
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

std::vector<GatherHit> trace_gather(const RayScene& scene, const PatchGrid& grid,
                                    const Vec3& receiver, const GatherSettings& settings,
                                    std::uint64_t frame_seed, WorkerPool& workers,
                                    std::uint64_t& segments) {
    const std::size_t batches = batch_count(settings);
    std::vector<std::vector<GatherHit>> found(batches);
    std::vector<std::uint64_t> counts(batches, 0);
    workers.run(batches, [&](std::size_t i) {
        trace_batch(scene, grid, receiver, settings, frame_seed, static_cast<int>(i), found[i],
                    [&](const std::vector<Ray>& wave) { counts[i] += wave.size(); });
    });
    for (const std::uint64_t count : counts) segments += count;
    return joined_by_patch(found, grid.size(), grid.patch_size_m());
}

std::vector<Ray> gather_rays(const RayScene& scene, const PatchGrid& grid, const Vec3& receiver,
                             const GatherSettings& settings, std::uint64_t frame_seed) {
    std::vector<Ray> all;
    std::vector<GatherHit> unused;
    for (std::size_t i = 0; i < batch_count(settings); ++i) {
        trace_batch(
            scene, grid, receiver, settings, frame_seed, static_cast<int>(i), unused,
            [&](const std::vector<Ray>& wave) { all.insert(all.end(), wave.begin(), wave.end()); });
    }
    return all;
}

void add_gathered(const std::vector<GatherHit>& hits, const PatchCache& cache, double share,
                  WorkerPool& workers, EnergyResponse& response) {
    if (cache.emitted() == 0) return;
    const TimeBins& bins = response.bins;
    const std::vector<Region> regions = regions_of(bins);
    const double scale = share * PatchCache::kUnit / static_cast<double>(cache.emitted());
    std::vector<Partial> partials(kChunks);
    workers.run(kChunks, [&](std::size_t chunk) {
        Partial& partial = partials[chunk];
        partial.energy.assign((bins.count() + 1) * kBandCount, 0);
        partial.direction.assign((bins.count() + 1) * 4, 0);
        FloatRow row;
        row.energy.resize(bins.count() * kBandCount);
        row.sum.resize(bins.count());
        if (cache.directed()) row.moment.resize(bins.count() * 4);
        const std::size_t late_bin = bins.index(kLate_s);
        std::uint32_t present = PatchGrid::kNone;
        for (std::size_t i = hits.size() * chunk / kChunks; i < hits.size() * (chunk + 1) / kChunks;
             ++i) {
            const GatherHit& hit = hits[i];
            if (hit.patch >= cache.row_count()) continue;
            const PatchCache::Row& source = cache.row(hit.patch);
            if (source.end_bin == 0) continue;
            if (hit.patch != present) {
                present = hit.patch;
                row.first_bin = row.end_bin = source.first_bin;
                row.total = {};
            }
            // Late hits come first within a patch, so that a row is converted once.
            const std::size_t end_bin =
                hit.late ? source.end_bin : std::min<std::size_t>(source.end_bin, late_bin);
            if (row.end_bin < end_bin) {
                convert_row(source.sum, row.end_bin, end_bin, scale, row.energy.data(),
                            row.sum.data(), row.total);
                if (cache.directed()) {
                    convert_moments(source.moment, row.end_bin, end_bin, scale, row.moment.data());
                }
                row.end_bin = end_bin;
            }
            if (!(row.total.sum() > 0)) continue;
            const double shift_s = double{hit.length_m} / double{response.speed_of_sound_m_s};
            add_row(row, row.first_bin, std::min(end_bin, late_bin), 1, hit, bins, regions, shift_s,
                    partial);
            if (hit.late) {
                add_row(row, std::max(row.first_bin, late_bin), end_bin, 1 / kLateShare, hit, bins,
                        regions, shift_s, partial);
            }
        }
    });
    for (std::size_t k = 0; k < bins.count(); ++k) {
        Bands energy;
        Vec3 direction(0);
        for (const Partial& partial : partials) {
            for (std::size_t b = 0; b < kBandCount; ++b) {
                energy[b] += partial.energy[k * kBandCount + b];
            }
            direction += Vec3(partial.direction[k * 4], partial.direction[k * 4 + 1],
                              partial.direction[k * 4 + 2]);
        }
        // Directions are weighted by a row's whole spectrum, which may differ from that of one bin.
        const float length = glm::length(direction);
        if (length > energy.sum()) direction *= energy.sum() / length;
        response.energy[k] += energy;
        response.direction[k] += direction;
    }
}

}  // namespace aula
