#include "engine/cache/patch_cache.h"

#include <algorithm>
#include <numeric>

#include "engine/base/band_vector.h"
#include "process/multiversion.h"

namespace aula {

namespace {

constexpr std::size_t kMoments = RowPool::kMoments;
/// Deposits between the prefetch of a sum and its use. A choice: each takes some nanoseconds, and a
/// line from memory some hundred.
constexpr std::size_t kPrefetchDistance = 28;

}  // namespace

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
void PatchCache::add_batch(PatchCache& cache, const DepositBatch& batch, std::size_t part) {
    const std::vector<Deposit>& deposits = batch.deposits.part[part];
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

void PatchCache::add_part(std::span<const DepositBatch> batches, std::size_t part) {
    for (const DepositBatch& batch : batches) best_version<add_batch>(*this, batch, part);
}

std::size_t PatchCache::allocated_rows() const {
    return std::accumulate(allocated_rows_.begin(), allocated_rows_.end(), std::size_t{0});
}

std::size_t PatchCache::memory_bytes() const {
    return table_.rows.capacity() * sizeof(Row) +
           allocated_rows() * row_bytes(bin_count_, directed_);
}

}  // namespace aula
