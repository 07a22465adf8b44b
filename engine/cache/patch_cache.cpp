#include "engine/cache/patch_cache.h"

#include <algorithm>
#include <array>
#include <bit>
#include <numeric>

#include "engine/base/band_vector.h"
#include "process/multiversion.h"

namespace aula {

namespace {

constexpr std::size_t kMoments = RowPool::kMoments;
constexpr std::size_t kPrefetchDistance = 28;  // deposits

}  // namespace

DirectionMoments PatchCache::Row::directions_at(std::size_t bin) const {
    std::array<float, kMoments> moments;
    std::copy_n(&directions[bin * kMoments], kMoments, moments.begin());
    return std::bit_cast<DirectionMoments>(moments);
}

PatchCache::PatchCache(std::size_t bin_count, bool directed, std::shared_ptr<RowPool> memory)
    : bin_count_(bin_count),
      directed_(directed),
      table_(memory ? std::move(memory) : std::make_shared<RowPool>(bin_count)) {}

PatchCache::Table& PatchCache::Table::operator=(Table&& other) noexcept {
    std::swap(memory, other.memory);
    std::swap(rows, other.rows);
    return *this;
}

/// Gives the rows back.
void PatchCache::Table::clear() {
    for (const Row& row : rows)
        memory->give_back(row.sum, row.directions, row.first_bin, row.end_bin);
    rows.clear();
}

std::size_t PatchCache::row_bytes(std::size_t bin_count, bool directed) {
    return bin_count * (kBandCount + (directed ? kMoments : 0)) * sizeof(float);
}

void PatchCache::clear() {
    table_.clear();
    emitted_ = 0;
    allocated_rows_ = {};
}

void PatchCache::begin_add(int rays, std::size_t patch_count) {
    if (table_.rows.size() < patch_count) table_.rows.resize(patch_count);
    emitted_ += static_cast<std::uint64_t>(rays);
}

AULA_MULTIVERSION
void PatchCache::add_batch(PatchCache& cache, const DepositBatch& batch,
                           const std::vector<Deposit>& deposits, std::size_t part) {
    for (std::size_t i = 0; i < deposits.size(); ++i) {
        // Prefetch: sums are scattered in memory.
        if (i + kPrefetchDistance < deposits.size()) {
            const Deposit& soon = deposits[i + kPrefetchDistance];
            const Row& row = cache.table_.rows[soon.patch];
            if (row.sum) __builtin_prefetch(&row.sum[soon.bin * kBandCount], 1);
            if (row.directions) __builtin_prefetch(&row.directions[soon.bin * kMoments], 1);
        }
        const Deposit& deposit = deposits[i];
        Row& row = cache.table_.rows[deposit.patch];
        if (!row.sum) {
            row.sum = cache.table_.memory->take_sums();
            if (cache.directed_) row.directions = cache.table_.memory->take_directions();
            ++cache.allocated_rows_[part];
        }
        row.first_bin = std::min<std::uint32_t>(row.first_bin, deposit.bin);
        row.end_bin = std::max<std::uint32_t>(row.end_bin, deposit.bin + 1U);
        const BandVector energy = deposit.energy();
        float* const sum = &row.sum[deposit.bin * kBandCount];
        store_bands(load_bands(sum) + energy, sum);
        store_bands(load_bands(row.total) + energy, row.total.value.data());
        if (cache.directed_) {
            const float all = sum_of_bands(energy)[0];
            const auto from = load_moments(DirectionMoments::of(batch.departures[deposit.ray]));
            float* const directions = &row.directions[deposit.bin * kMoments];
            store_bands(load_bands(directions) + from * all, directions);
        }
    }
}

void PatchCache::add_part(std::span<const DepositBatch> batches,
                          DepositParts DepositBatch::*deposits, std::size_t part) {
    for (const DepositBatch& batch : batches)
        best_version<add_batch>(*this, batch, (batch.*deposits).part[part], part);
}

void PatchCache::set_row(std::uint32_t index, const ShiftedHistogram& sum) {
    Row& row = table_.rows[index];
    for (std::size_t k = 0; k < bin_count_; ++k) {
        const Bands energy = sum.energy(k);
        if (!(energy.max() > 0)) continue;
        if (!row.sum) {
            row.sum = table_.memory->take_sums();
            if (directed_) row.directions = table_.memory->take_directions();
        }
        row.first_bin = std::min<std::uint32_t>(row.first_bin, static_cast<std::uint32_t>(k));
        row.end_bin = static_cast<std::uint32_t>(k + 1);
        row.total += energy;
        store_bands(load_bands(energy), &row.sum[k * kBandCount]);
        if (directed_) {
            const BandVector moments = load_moments(sum.directions(k));
            store_bands(moments, &row.directions[k * kMoments]);
        }
    }
}

std::size_t PatchCache::allocated_rows() const {
    return std::accumulate(allocated_rows_.begin(), allocated_rows_.end(), std::size_t{0});
}

std::size_t PatchCache::memory_bytes() const {
    return table_.rows.capacity() * sizeof(Row) +
           allocated_rows() * row_bytes(bin_count_, directed_);
}

}  // namespace aula
