#include "engine/cache/transport_cache.h"

#include <algorithm>
#include <cmath>

#include "engine/base/band_vector.h"
#include "engine/base/shifted_histogram.h"
#include "process/multiversion.h"

namespace aula {

namespace {

/// Most regions from which transport is learnt. The time for a prediction increases with the square
/// of their number; errors of the energy are below 1 % with 40 in a room and with 64 in a church.
constexpr std::size_t kMostStarts = 32;

/// hand_over_m() in regions: paths of less than a region and a half depend on where in its regions
/// they begin and end.
constexpr float kHandOver = 1.5F;

/// Hits at the mean of its region that every row with hits has beside its own: with few hits the
/// noise of the importance would bias energies.
constexpr double kVirtualHits = 4;

/// The same for the area, as a share of the mean area of a row: small areas are known by few
/// samples.
constexpr double kVirtualArea = 0.25;

/// Energies that leave regions within kShortest_s, or kLonger of their time, have one distribution
/// over the regions; within the shortest part, or that share of their time, one time.
constexpr double kShortest_s = 0.006;
constexpr double kLonger = 0.7;
constexpr double kShortestPart_s = 0.002;
constexpr double kLongerPart = 0.1;

/// Adds bins [first, end) of a row of the transport, times the factors of the bins and `left`.
AULA_MULTIVERSION
void add_weighted(const float* row, const Bands* factors, std::size_t first, std::size_t end,
                  const Bands& left, float* out) {
    const BandVector weights = load_bands(left);
    for (std::size_t k = first; k < end; ++k) {
        const std::size_t at = k * kBandCount;
        store_bands(load_bands(out + at) + weights * load_bands(factors[k]) * load_bands(row + at),
                    out + at);
    }
}

/// The same for the directions, `moments` for unit energy.
AULA_MULTIVERSION
void add_directions(const float* row, const Bands* factors, std::size_t first, std::size_t end,
                    const Bands& left, const DirectionMoments& moments, float* out) {
    const BandVector weights = load_bands(left);
    const BandVector directions = load_moments(moments);
    for (std::size_t k = first; k < end; ++k) {
        const std::size_t at = k * kBandCount;
        const BandVector sum =
            sum_of_bands(weights * load_bands(factors[k]) * load_bands(row + at));
        store_bands(load_bands(out + at) + directions * sum, out + at);
    }
}

/// The energy that leaves the regions within a time. Its distribution over the regions is taken for
/// constant within it.
struct Departures {
    struct Part {
        double energy = 0;
        double moment_s = 0;  ///< sum of energies times times
        Bands energies;

        double time_s() const { return moment_s / energy; }
    };
    double begin_s = 0;
    std::vector<Bands> of_region;              ///< [region]
    std::vector<DirectionMoments> directions;  ///< [region] sums; of a listener's rays
    std::vector<Part> parts;
    Bands total;
};

std::vector<Departures> departures(const PatchCache& from, const TimeBins& bins) {
    std::vector<Departures> all;
    double end_s = 0;
    double part_end_s = 0;
    for (std::size_t k = 0; k < bins.count(); ++k) {
        const double begin_s = bins.begin_s(k);
        if (begin_s >= end_s) {
            Departures& next = all.emplace_back();
            next.begin_s = begin_s;
            next.of_region.resize(from.row_count());
            if (from.directed()) next.directions.resize(from.row_count());
            end_s = begin_s + std::max(kShortest_s, kLonger * begin_s);
            part_end_s = 0;
        }
        Departures& departures = all.back();
        if (begin_s >= part_end_s) {
            departures.parts.emplace_back();
            part_end_s = begin_s + std::max(kShortestPart_s, kLongerPart * begin_s);
        }
        Departures::Part& part = departures.parts.back();
        const double middle_s = (begin_s + bins.end_s(k)) / 2;
        for (std::uint32_t region = 0; region < from.row_count(); ++region) {
            const PatchCache::Row& row = from.row(region);
            if (k < row.first_bin || k >= row.end_bin) continue;
            Bands energy;
            store_bands(load_bands(row.sum + k * kBandCount), energy.value.data());
            departures.of_region[region] += energy;
            if (from.directed()) departures.directions[region] += row.directions_at(k);
            part.energies += energy;
            part.energy += double{energy.sum()};
            part.moment_s += double{energy.sum()} * middle_s;
        }
    }
    for (Departures& departures : all) {
        std::erase_if(departures.parts, [](const auto& part) { return !(part.energy > 0); });
        for (const Departures::Part& part : departures.parts) departures.total += part.energies;
    }
    std::erase_if(all, [](const Departures& departures) { return departures.parts.empty(); });
    return all;
}

}  // namespace

TransportCache::TransportCache(const RayScene& scene, const PatchGrid& grid, const TimeBins& bins,
                               double memory_bytes, WorkerPool& workers)
    : scene_(scene), grid_(grid), bins_(bins), workers_(workers), transport_(bins.count()) {
    const double pairs = memory_bytes / double(PatchCache::row_bytes(bins.count(), false));
    most_starts_ = std::min(kMostStarts, static_cast<std::size_t>(std::sqrt(pairs)));
    find_regions();
}

void TransportCache::find_regions() {
    regions_.emplace(scene_, grid_, most_starts_, workers_);
    restart();
}

void TransportCache::restart() {
    late_.assign(grid_.size(), {});
    late_energy_.assign(bins_.count(), 0);
    late_hits_.assign(bins_.count(), 0);
    transport_.clear();
    starts_.assign(start_count() * (bins_.count() + 1), {});
    started_.assign(grid_.size(), 0);
    find_shares();
}

float TransportCache::hand_over_m() const { return kHandOver * region_size_m(); }

void TransportCache::learn(std::span<const DepositBatch> batches, int rays) {
    transport_.begin_add(rays, start_count() * region_count());
    workers_.run(DepositParts::kCount, [&](std::size_t part) {
        transport_.add_part(batches, &DepositBatch::transport, part);
    });
    for (const DepositBatch& batch : batches) {
        for (const DepositBatch::Start& start : batch.starts) {
            starts_[regions()[start.row] * (bins_.count() + 1) + start.end_bin] += start.energy;
            started_[start.row] += 1;
        }
    }
    count_late(batches);
    find_shares();
}

/// Adds the late energies. Those of a time bin are relative to their mean, which undoes the decay:
/// hits alone are as frequent in all parts of a room.
void TransportCache::count_late(std::span<const DepositBatch> batches) {
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
    workers_.run(DepositParts::kCount, [&](std::size_t part) {
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
        double radiating_m2 = 0;
        double arrived = 0;
        Bands radiated;
        Bands shares;
    };
    std::vector<Region> found(region_count());
    std::vector<double> area_m2(late_.size());
    std::vector<double> radiating_m2(late_.size());  // times the factors of the energies
    for (std::uint32_t row = 0; row < late_.size(); ++row) {
        const PatchGrid::RowArea area = grid_.row_area(row);
        area_m2[row] = double{area.area_m2};
        radiating_m2[row] = double{area.area_m2 * area.factor};
        if (late_[row].hits == 0 || regions()[row] == PatchRegions::kNone) continue;
        Region& region = found[regions()[row]];
        ++region.rows;
        region.hits += double{late_[row].hits};
        region.area_m2 += area_m2[row];
        region.radiating_m2 += radiating_m2[row];
        region.arrived += double{late_[row].arrived};
        region.radiated += late_[row].radiated;
    }
    importance_.assign(late_.size(), 1);
    shares_.assign(late_.size(), {});
    for (std::uint32_t row = 0; row < late_.size(); ++row) {
        if (regions()[row] == PatchRegions::kNone) continue;
        Region& region = found[regions()[row]];
        if (!(region.area_m2 > 0)) {
            shares_[row] = Bands::filled(static_cast<float>(radiating_m2[row]));
        } else if (late_[row].hits > 0) {
            const double relative_area = area_m2[row] * region.rows / region.area_m2;
            const double added = kVirtualHits / region.hits;  // share of the region's energy
            const double arrived =
                (double{late_[row].arrived} / region.arrived + added * relative_area) *
                region.rows / (1 + added * region.rows);
            shares_[row] = late_[row].radiated +
                           region.radiated * static_cast<float>(added * radiating_m2[row] *
                                                                region.rows / region.radiating_m2);
            importance_[row] =
                static_cast<float>((arrived + kVirtualArea) / (relative_area + kVirtualArea));
        }
        region.shares += shares_[row];
    }
    for (std::uint32_t row = 0; row < late_.size(); ++row) {
        if (regions()[row] == PatchRegions::kNone) continue;
        const Bands& all = found[regions()[row]].shares;
        for (std::size_t b = 0; b < kBandCount; ++b)
            shares_[row][b] = all[b] > 0 ? shares_[row][b] / all[b] : 0;
    }
}

/// [from][bin] 1 / the energy that has started there and is observed in the bin, times the
/// importance.
std::vector<Bands> TransportCache::per_start() const {
    std::vector<double> importance(start_count());
    std::vector<double> started(start_count());
    for (std::uint32_t row = 0; row < late_.size(); ++row) {
        if (started_[row] == 0) continue;
        importance[regions()[row]] += double{started_[row] * importance_[row]};
        started[regions()[row]] += double{started_[row]};
    }
    std::vector<Bands> factors(start_count() * bins_.count());
    for (std::size_t from = 0; from < start_count(); ++from) {
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

void TransportCache::predict(const PatchCache& handed_over, PatchCache& radiated) const {
    const std::size_t bins = bins_.count();
    const bool directed = handed_over.directed();
    const std::vector<Bands> factors = per_start();
    const std::vector<Departures> left = departures(handed_over, bins_);
    workers_.run(region_count(), [&](std::size_t to) {
        std::vector<float> energies(bins * kBandCount);
        std::vector<float> directions(directed ? energies.size() : 0);
        ShiftedHistogram sum(bins_);
        for (const Departures& departures : left) {
            // What arrives after the response is lost.
            const std::size_t last = bins_.index(bins_.length_s() - departures.begin_s);
            std::fill(energies.begin(), energies.end(), 0.0F);
            std::fill(directions.begin(), directions.end(), 0.0F);
            Bands total;
            for (std::size_t from = 0; from < handed_over.row_count(); ++from) {
                const Bands& energy = departures.of_region[from];
                const PatchCache::Row& row =
                    transport_.row(static_cast<std::uint32_t>(from * region_count() + to));
                if (!row.sum || !(energy.max() > 0)) continue;
                const std::size_t end = std::min<std::size_t>(row.end_bin, last);
                total += row.total * energy;
                best_version<add_weighted>(row.sum, &factors[from * bins], row.first_bin, end,
                                           energy, energies.data());
                if (!directed) continue;
                best_version<add_directions>(
                    row.sum, &factors[from * bins], row.first_bin, end, energy,
                    departures.directions[from] * (1 / energy.sum()), directions.data());
            }
            if (!(total.sum() > 0)) continue;
            for (const Departures::Part& part : departures.parts) {
                Bands weight;
                for (std::size_t b = 0; b < kBandCount; ++b) {
                    if (departures.total[b] > 0) weight[b] = part.energies[b] / departures.total[b];
                }
                sum.add({energies.data(), directed ? directions.data() : nullptr, total}, 0, last,
                        part.time_s(), weight, {});
            }
        }
        radiated.set_row(static_cast<std::uint32_t>(to), sum);
    });
}

}  // namespace aula
