#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "engine/base/worker_pool.h"
#include "engine/cache/row_pool.h"
#include "engine/trace/trace_batch.h"

namespace aula {

/// The energy that every patch radiates for one emitter, B(patch, arrival-time bin), independent of
/// the other end. For a listener it also stores the arrival direction, which is the direction of
/// emission of the rays. While neither emitter nor scene changes, all frames accumulate. After a
/// change it keeps a window of frames: none older than tau, and none from which emitter or scene
/// has moved far relative to the patch size. Sums are 64-bit fixed point, so that removal is exact.
/// [propagation thread]
class PatchCache {
 public:
    /// Unit of the energy sums, relative to a ray's initial energy.
    static constexpr double kUnit = Deposit::kUnit;

    /// From this number of rays on, their noise is below that of the gather. Their sums (of all
    /// bands for the intensity) stay below 2^63 units even if each ray meets a patch forty times in
    /// one bin.
    static constexpr std::uint64_t kEnoughRays = 1ULL << 20;

    /// Number of frames that are kept when a static end or scene begins to move, at most. The sums
    /// then hold frames that are not logged and are rebuilt in one frame, whose cost this limits. A
    /// walk at 1.5 m/s and 30 frames a second keeps as many.
    static constexpr std::size_t kKeptAtStart = 2;

    /// The state on which the rays of a frame depend.
    struct State {
        std::uint64_t frame = 0;
        Vec3 emitter{0};
        double travel_m = 0;  ///< accumulated movement of the scene since the start

        bool changed_since(const State& older) const {
            return emitter != older.emitter || travel_m != older.travel_m;
        }
        double moved_m(const State& older) const;
    };

    /// The radiated energy of one patch, zero outside [first_bin, end_bin) and nonzero in the first
    /// and last bin of it. The memory has zeros there, too.
    struct alignas(64) Row {
        std::int64_t* sum = nullptr;        ///< [bin][band]
        std::int64_t* intensity = nullptr;  ///< [bin][axis] see EnergyResponse::intensity; null
                                            ///< for a source
        std::uint64_t deposits = 0;
        std::uint32_t first_bin = ~0U;
        std::uint32_t end_bin = 0;
    };

    /// `window_frames` is F >= 1. Frames are logged for later removal in the part of `memory_bytes`
    /// that the sums leave. `directed`: stores the intensity. `memory` holds the rows, of
    /// `bin_count` bins; absent: memory of this cache only.
    PatchCache(std::size_t bin_count, int window_frames, float patch_size_m,
               std::size_t memory_bytes, bool directed = false,
               std::shared_ptr<RowPool> memory = nullptr);

    /// Sets the memory limit from the next frame on.
    void set_memory_bytes(std::size_t memory_bytes) { memory_bytes_ = memory_bytes; }

    /// Bytes of one patch's row.
    static std::size_t row_bytes(std::size_t bin_count, bool directed);

    /// True at kEnoughRays or more.
    bool complete() const;

    /// True if no stored frame precedes the last change.
    bool is_current() const { return fresh_frames_ == summed_frames_; }

    /// Removes frames that are no longer valid, and all frames from before the last change unless
    /// they are `wanted`. Call once for each frame, in ascending order.
    void advance(const State& now, bool wanted, WorkerPool& workers);

    /// Adds the deposits of one frame, after advance(), all on patches below `patch_count`. Takes
    /// over the batches' memory; clear the batches before reuse.
    void add_frame(int rays, std::size_t patch_count, std::span<DepositBatch> batches,
                   WorkerPool& workers);

    /// `patch` < row_count().
    const Row& row(std::uint32_t patch) const { return table_.rows[patch]; }
    std::size_t row_count() const { return table_.rows.size(); }
    bool directed() const { return directed_; }

    /// Number of rays of the frames in the sums.
    std::uint64_t emitted() const { return emitted_; }

    std::size_t occupied() const;
    std::size_t allocated_rows() const { return allocated_rows_; }
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
    struct Batch {
        DepositParts deposits;
        std::vector<Vec3> departures;
    };
    struct Frame {
        State state;
        std::uint64_t rays = 0;
        std::vector<Batch> batches;
    };
    static std::size_t bytes_of(const std::vector<Batch>& batches);
    void apply(const Frame& frame, std::int64_t sign, WorkerPool& workers);
    std::size_t apply_batch(const Batch& batch, std::size_t part, std::int64_t sign);
    void clear_sums(WorkerPool& workers);
    void trim(Row& row) const;
    void keep_newest(std::size_t frames, WorkerPool& workers);
    bool holds(const Frame& frame) const;
    void trim_log(WorkerPool& workers);
    void forget_aged();
    std::size_t table_bytes() const;
    bool is_consistent() const;

    std::size_t bin_count_;
    std::size_t window_frames_;
    float patch_size_m_;
    std::size_t memory_bytes_;
    bool directed_;
    State now_;
    Table table_;

    /// The sums hold the newest `summed_frames_` frames, which emitted `emitted_` rays; the sums of
    /// `allocated_rows_` rows exist. The newest `fresh_frames_` of these frames are those since the
    /// last change of emitter or scene. Right after the first of them the sums held `window_then_`
    /// frames: each further one replaces an older frame until only fresh ones are left. The log
    /// holds the newest of the summed frames, and all of them while some precede the change.
    /// Checked by is_consistent() after each frame.
    std::size_t summed_frames_ = 0;
    std::size_t fresh_frames_ = 0;
    std::size_t window_then_ = 0;
    std::uint64_t emitted_ = 0;
    std::size_t allocated_rows_ = 0;
    std::deque<Frame> log_;     ///< newest last
    std::vector<Batch> spare_;  ///< memory of a removed frame, for reuse
};

}  // namespace aula
