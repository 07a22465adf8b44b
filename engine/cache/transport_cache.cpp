#include "engine/cache/transport_cache.h"

#include <algorithm>
#include <cmath>

#include "engine/base/band_vector.h"
#include "engine/base/shifted_histogram.h"
#include "process/multiversion.h"

namespace aula {

namespace {

/// Regions are at least this number of patches wide: with 2 m in a room of 10 m the energy of a
/// region is distributed as late in the response within 0.2 %.
constexpr float kPatchesAcross = 4;

/// Regions are larger where they would be more. The time for a prediction increases with the square
/// of their number; errors of the energy are below 1 % with 40 in a room and with 64 in a church.
constexpr std::size_t kMostRegions = 64;
constexpr float kCoarser = 1.25F;

/// hand_over_m() in regions: paths of less than a region and a half depend on where in its regions
/// they begin and end.
constexpr float kHandOver = 1.5F;

/// Hits at the mean of its region that every row with hits has beside its own: with few hits the
/// noise of the importance would bias energies.
constexpr double kVirtualHits = 4;

/// The same for the area, as a share of the mean area of a row: small areas are known by few
/// samples.
constexpr double kVirtualArea = 0.25;

/// Energies that leave regions within this time, or this share of their time, are delayed by their
/// mean time: the transport changes little within it after the hand-over.
constexpr double kLeastGroup_s = 0.004;
constexpr double kGroup = 0.2;

AULA_MULTIVERSION
void multiply(const float* energy, const Bands* factors, std::size_t first, std::size_t end,
              float* out) {
    for (std::size_t k = first; k < end; ++k) {
        store_bands(load_bands(energy + k * kBandCount) * load_bands(factors[k]),
                    out + k * kBandCount);
    }
}

AULA_MULTIVERSION
void add_weighted(const float* energy, const Bands& weight, std::size_t first, std::size_t end,
                  float* out) {
    const BandVector weights = load_bands(weight);
    for (std::size_t k = first; k < end; ++k) {
        store_bands(
            load_bands(out + k * kBandCount) + weights * load_bands(energy + k * kBandCount),
            out + k * kBandCount);
    }
}

/// Adds the directions of the weighted energy, `moments` for unit energy.
AULA_MULTIVERSION
void add_directions(const float* energy, const Bands& weight, const DirectionMoments& moments,
                    std::size_t first, std::size_t end, float* out) {
    const BandVector weights = load_bands(weight);
    const BandVector directions = load_moments(moments);
    for (std::size_t k = first; k < end; ++k) {
        const BandVector sum = sum_of_bands(weights * load_bands(energy + k * kBandCount));
        store_bands(load_bands(out + k * kBandCount) + directions * sum, out + k * kBandCount);
    }
}

/// The energy that leaves each region at about one time.
struct Departures {
    double energy = 0;
    double moment_s = 0;                       ///< sum of energies times times
    std::vector<Bands> of_region;              ///< [region]
    std::vector<DirectionMoments> directions;  ///< [region] sums; of a listener's rays

    double time_s() const { return moment_s / energy; }
};

std::vector<Departures> departures(const PatchCache& from, const TimeBins& bins) {
    std::vector<Departures> groups;
    double end_s = 0;
    for (std::size_t k = 0; k < bins.count(); ++k) {
        if (bins.begin_s(k) >= end_s) {
            groups.emplace_back().of_region.resize(from.row_count());
            if (from.directed()) groups.back().directions.resize(from.row_count());
            end_s = bins.begin_s(k) + std::max(kLeastGroup_s, kGroup * bins.begin_s(k));
        }
        Departures& group = groups.back();
        const double middle_s = (bins.begin_s(k) + bins.end_s(k)) / 2;
        for (std::uint32_t region = 0; region < from.row_count(); ++region) {
            const PatchCache::Row& row = from.row(region);
            if (k < row.first_bin || k >= row.end_bin) continue;
            Bands energy;
            store_bands(load_bands(row.sum + k * kBandCount), energy.value.data());
            group.of_region[region] += energy;
            group.energy += double{energy.sum()};
            group.moment_s += double{energy.sum()} * middle_s;
            if (from.directed()) group.directions[region] += row.directions_at(k);
        }
    }
    std::erase_if(groups, [](const Departures& group) { return !(group.energy > 0); });
    return groups;
}

}  // namespace

TransportCache::TransportCache(const RayScene& scene, const PatchGrid& grid, const TimeBins& bins,
                               double memory_bytes)
    : grid_(grid),
      bins_(bins),
      cells_(cells(scene, grid, bins, memory_bytes)),
      transport_(bins.count()) {
    restart();
}

/// The cells of the regions.
CellGrid TransportCache::cells(const RayScene& scene, const PatchGrid& grid, const TimeBins& bins,
                               double memory_bytes) {
    const double pairs = memory_bytes / double(PatchCache::row_bytes(bins.count(), false));
    const double most = std::min(static_cast<double>(kMostRegions), std::sqrt(pairs));
    float last_count = 0;
    for (float size_m = kPatchesAcross * grid.patch_size_m();; size_m *= kCoarser) {
        CellGrid cells(scene, size_m);
        std::vector<std::uint64_t> keys;
        for (std::uint32_t row = 0; row < grid.size(); ++row) {
            const PatchCell cell = grid.cell(row);
            keys.push_back(cells.key_at((cell.low + cell.high) * 0.5F, cell.direction));
        }
        std::sort(keys.begin(), keys.end());
        const auto count = static_cast<float>(std::unique(keys.begin(), keys.end()) - keys.begin());
        // Beyond the size of the scene there remain its directions.
        if (double{count} <= most || count == last_count) return cells;
        last_count = count;
    }
}

void TransportCache::restart() {
    numbers_.clear();
    regions_.clear();
    late_.clear();
    late_energy_.assign(bins_.count(), 0);
    late_hits_.assign(bins_.count(), 0);
    scene_moved();
}

void TransportCache::scene_moved() {
    find_regions();
    transport_.clear();
    starts_.assign(region_count() * (bins_.count() + 1), {});
    started_.assign(regions_.size(), 0);
    find_shares();
}

float TransportCache::hand_over_m() const { return kHandOver * region_size_m(); }

/// Rows that belong to another region than before have no late energy.
void TransportCache::find_regions() {
    const std::size_t before = regions_.size();
    regions_.resize(grid_.size());
    late_.resize(grid_.size());
    for (std::uint32_t row = 0; row < regions_.size(); ++row) {
        const PatchCell cell = grid_.cell(row);
        const std::uint64_t key = cells_.key_at((cell.low + cell.high) * 0.5F, cell.direction);
        const std::uint32_t region =
            numbers_.try_emplace(key, static_cast<std::uint32_t>(numbers_.size())).first->second;
        if (row >= before || region != regions_[row]) late_[row] = {};
        regions_[row] = region;
    }
}

void TransportCache::learn(std::span<const DepositBatch> batches, int rays, WorkerPool& workers) {
    transport_.begin_add(rays, region_count() * region_count());
    workers.run(DepositParts::kCount, [&](std::size_t part) {
        transport_.add_part(batches, &DepositBatch::transport, part);
    });
    for (const DepositBatch& batch : batches) {
        for (const DepositBatch::Start& start : batch.starts) {
            starts_[regions_[start.row] * (bins_.count() + 1) + start.end_bin] += start.energy;
            started_[start.row] += 1;
        }
    }
    count_late(batches, workers);
    find_shares();
}

/// Adds the late energies. Those of a time bin are relative to their mean, which undoes the decay:
/// hits alone are as frequent in all parts of a room.
void TransportCache::count_late(std::span<const DepositBatch> batches, WorkerPool& workers) {
    for (const DepositBatch& batch : batches) {
        for (const DepositBatch::LateHit& hit : batch.late_hits) {
            late_energy_[hit.bin] += double{hit.energy};
            ++late_hits_[hit.bin];
        }
    }
    std::vector<float> weights(bins_.count());
    for (std::size_t k = 0; k < weights.size(); ++k) {
        if (late_energy_[k] > 0) weights[k] = static_cast<float>(late_hits_[k] / late_energy_[k]);
    }
    for (const DepositBatch& batch : batches) {
        for (const DepositBatch::LateHit& hit : batch.late_hits) {
            late_[hit.row].arrived += weights[hit.bin] * hit.energy;
            late_[hit.row].hits += 1;
        }
    }
    workers.run(DepositParts::kCount, [&](std::size_t part) {
        for (const DepositBatch& batch : batches) {
            for (const Deposit& deposit : batch.later.part[part]) {
                Bands& radiated = late_[deposit.patch].radiated;
                store_bands(load_bands(radiated) + deposit.energy() * weights[deposit.bin],
                            radiated.value.data());
            }
        }
    });
}

/// Distributes the energy of regions among their rows: by the late energies or, where there are
/// none yet, by the areas.
void TransportCache::find_shares() {
    struct Region {
        double rows = 0;  ///< with hits
        double hits = 0;
        double area_m2 = 0;
        double arrived = 0;
        Bands radiated;
        Bands shares;
    };
    std::vector<Region> regions(region_count());
    std::vector<double> area_m2(regions_.size());
    for (std::uint32_t row = 0; row < regions_.size(); ++row) {
        const float per_m2 = grid_.per_m2(row);
        if (per_m2 > 0) area_m2[row] = 1 / double{per_m2};
        if (late_[row].hits == 0) continue;
        Region& region = regions[regions_[row]];
        ++region.rows;
        region.hits += double{late_[row].hits};
        region.area_m2 += area_m2[row];
        region.arrived += double{late_[row].arrived};
        region.radiated += late_[row].radiated;
    }
    importance_.assign(regions_.size(), 1);
    shares_.assign(regions_.size(), {});
    for (std::uint32_t row = 0; row < regions_.size(); ++row) {
        Region& region = regions[regions_[row]];
        if (!(region.area_m2 > 0)) {
            shares_[row] = Bands::filled(static_cast<float>(area_m2[row]));
        } else if (late_[row].hits > 0) {
            const double relative_area = area_m2[row] * region.rows / region.area_m2;
            const double added = kVirtualHits / region.hits;  // share of the region's energy
            const double arrived =
                (double{late_[row].arrived} / region.arrived + added * relative_area) *
                region.rows / (1 + added * region.rows);
            shares_[row] =
                late_[row].radiated + region.radiated * static_cast<float>(added * relative_area);
            importance_[row] =
                static_cast<float>((arrived + kVirtualArea) / (relative_area + kVirtualArea));
        }
        region.shares += shares_[row];
    }
    for (std::uint32_t row = 0; row < regions_.size(); ++row) {
        const Bands& all = regions[regions_[row]].shares;
        for (std::size_t b = 0; b < kBandCount; ++b)
            shares_[row][b] = all[b] > 0 ? shares_[row][b] / all[b] : 0;
    }
}

/// [from][bin] 1 / the energy that has started there and is observed in the bin, times the
/// importance.
std::vector<Bands> TransportCache::per_start() const {
    std::vector<double> importance(region_count());
    std::vector<double> started(region_count());
    for (std::uint32_t row = 0; row < regions_.size(); ++row) {
        importance[regions_[row]] += double{started_[row] * importance_[row]};
        started[regions_[row]] += double{started_[row]};
    }
    std::vector<Bands> factors(region_count() * bins_.count());
    for (std::size_t from = 0; from < region_count(); ++from) {
        if (!(started[from] > 0)) continue;
        const auto mean_importance = static_cast<float>(importance[from] / started[from]);
        Bands energy;
        for (std::size_t k = bins_.count(); k-- > 0;) {
            energy += starts_[from * (bins_.count() + 1) + k + 1];
            for (std::size_t b = 0; b < kBandCount; ++b) {
                if (energy[b] > 0)
                    factors[from * bins_.count() + k][b] = 1 / (mean_importance * energy[b]);
            }
        }
    }
    return factors;
}

void TransportCache::predict(const PatchCache& handed_over, PatchCache& radiated,
                             WorkerPool& workers) const {
    const std::size_t bins = bins_.count();
    const bool directed = handed_over.directed();
    const std::vector<Bands> factors = per_start();
    const std::vector<Departures> groups = departures(handed_over, bins_);
    workers.run(region_count(), [&](std::size_t to) {
        std::vector<float> of_start(bins * kBandCount);
        std::vector<float> energies(groups.size() * bins * kBandCount);
        std::vector<float> directions(directed ? energies.size() : 0);
        Bands total;
        for (std::size_t from = 0; from < handed_over.row_count(); ++from) {
            const PatchCache::Row& row =
                transport_.row(static_cast<std::uint32_t>(from * region_count() + to));
            if (!row.sum) continue;
            const std::size_t first = row.first_bin;
            total += row.total;
            best_version<multiply>(row.sum, &factors[from * bins], first, row.end_bin,
                                   of_start.data());
            for (std::size_t g = 0; g < groups.size(); ++g) {
                const Bands& left = groups[g].of_region[from];
                if (!(left.max() > 0)) continue;
                const std::size_t at = g * bins * kBandCount;
                best_version<add_weighted>(of_start.data(), left, first, row.end_bin,
                                           &energies[at]);
                if (!directed) continue;
                best_version<add_directions>(of_start.data(), left,
                                             groups[g].directions[from] * (1 / left.sum()), first,
                                             row.end_bin, &directions[at]);
            }
        }
        ShiftedHistogram sum(bins_);
        for (std::size_t g = 0; g < groups.size() && total.sum() > 0; ++g) {
            const std::size_t at = g * bins * kBandCount;
            sum.add({&energies[at], directed ? &directions[at] : nullptr, total}, 0, bins,
                    groups[g].time_s(), Bands::filled(1), {});
        }
        radiated.set_row(static_cast<std::uint32_t>(to), sum);
    });
}

}  // namespace aula
