#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "engine/cache/row_pool.h"
#include "engine/trace/trace_batch.h"

namespace aula {

/// The energy that every patch radiates for one emitter, B(patch, arrival-time bin), independent of
/// the other end. For a listener it also stores the directions of arrival, which are those of
/// emission of the rays. It accumulates all frames since the emitter or the scene last changed: the
/// owner clears it after each change. [propagation thread]
class PatchCache {
 public:
    /// From this number of rays on, their noise is below that of the gather. They leave some 10^4
    /// deposits in a bin, whose sum in single precision loses those below 0.1 % of their mean.
    static constexpr std::uint64_t kEnoughRays = 1ULL << 20;

    /// The radiated energy of one patch, zero outside [first_bin, end_bin) and nonzero in the first
    /// and last bin of it. The memory has zeros there, too. Threads that add to neighbouring
    /// patches share no cache line.
    struct alignas(64) Row {
        float* sum = nullptr;         ///< [bin][band], relative to a ray's initial energy
        float* directions = nullptr;  ///< [bin][moment], RowPool::kMoments, see
                                      ///< DirectionMoments; null for a source
        std::uint32_t first_bin = ~0U;
        std::uint32_t end_bin = 0;
        Bands total;  ///< over bins
    };

    /// `directed`: stores the directions. `memory` holds the rows, of `bin_count` bins; absent:
    /// memory of this cache only.
    explicit PatchCache(std::size_t bin_count, bool directed = false,
                        std::shared_ptr<RowPool> memory = nullptr);

    /// Bytes of one patch's row.
    static std::size_t row_bytes(std::size_t bin_count, bool directed);

    /// Removes all energy.
    void clear();

    /// Counts `rays` more rays, whose deposits are all on patches below `patch_count`. Call
    /// add_part() for each part of their deposits before any other use of the cache.
    void begin_add(int rays, std::size_t patch_count);

    /// Adds one of DepositParts::kCount parts of the rays' deposits. [any thread]
    void add_part(std::span<const DepositBatch> batches, std::size_t part);

    /// True at kEnoughRays or more.
    bool complete() const { return emitted_ >= kEnoughRays; }

    /// `patch` < row_count().
    const Row& row(std::uint32_t patch) const { return table_.rows[patch]; }
    std::size_t row_count() const { return table_.rows.size(); }
    bool directed() const { return directed_; }

    /// Number of rays whose energy it holds.
    std::uint64_t emitted() const { return emitted_; }

    /// Number of patches with energy.
    std::size_t allocated_rows() const;
    std::size_t memory_bytes() const;

 private:
    /// Rows, whose memory is given back to `memory`.
    struct Table {
        std::shared_ptr<RowPool> memory;
        std::vector<Row> rows{};

        explicit Table(std::shared_ptr<RowPool> of) : memory(std::move(of)) {}
        Table(Table&&) = default;
        Table& operator=(Table&& other) noexcept;
        ~Table() { clear(); }
        void clear();
    };
    static void add_batch(PatchCache& cache, const DepositBatch& batch, std::size_t part);

    std::size_t bin_count_;
    bool directed_;
    Table table_;
    std::uint64_t emitted_ = 0;
    std::array<std::size_t, DepositParts::kCount> allocated_rows_{};  ///< [part]
};

}  // namespace aula
