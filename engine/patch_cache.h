#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <span>
#include <vector>

#include "engine/path_tracer.h"
#include "engine/worker_pool.h"

namespace aula {

/// The energy that every patch radiates for one source, B(patch, arrival-time bin), whoever
/// listens. While neither source nor scene changes it gathers for ever; once something has changed
/// it keeps a window of frames: none older than tau, none from which the source or the scene has
/// moved far against the patch size. Sums are 64-bit fixed point, so that removing is exact.
/// [propagation thread]
class PatchCache {
 public:
    /// Energies are sums in units of 2^-34 of a ray's energy.
    static constexpr double kUnit = 0x1p-34;

    /// The radiated energy of one patch: [bin][band], zero outside [first_bin, end_bin).
    struct Row {
        std::unique_ptr<std::int64_t[]> sum;
        std::uint32_t first_bin = ~0U;
        std::uint32_t end_bin = 0;
    };

    /// `window_frames` is F >= 1. Frames are logged, to be taken out again, in `log_bytes`.
    PatchCache(std::size_t bin_count, int window_frames, float patch_size_m, std::size_t log_bytes);
    PatchCache(PatchCache&&) = default;
    PatchCache& operator=(PatchCache&&) = default;

    /// True once so many rays have been gathered that more would change nothing.
    bool complete(const Vec3& source, double travel_m) const;

    /// Takes the deposits of one frame, for a source position and the distance that anything in
    /// the scene has moved since the start. Takes the batches' deposits over; what is left in them
    /// is to be cleared.
    void add_frame(const Vec3& source, double travel_m, int rays, std::size_t patch_count,
                   std::span<TraceBatch> batches, WorkerPool& workers);

    const Row& row(std::uint32_t patch) const { return rows_[patch]; }
    std::size_t row_count() const { return rows_.size(); }

    /// Rays of the frames that the sums hold.
    std::uint64_t emitted() const { return emitted_; }

    std::size_t occupied() const;
    std::size_t memory_bytes() const;

 private:
    struct Frame {
        Vec3 source{0};
        double travel_m = 0;
        std::uint64_t rays = 0;
        std::vector<std::vector<Deposit>> deposits;

        std::size_t bytes() const;
    };
    void apply(const Frame& frame, std::int64_t sign, WorkerPool& workers);
    std::size_t frames_that_hold() const;

    std::size_t bin_count_;
    std::size_t window_frames_;
    float patch_size_m_;
    std::size_t log_bytes_;
    std::vector<Row> rows_;
    std::uint64_t emitted_ = 0;
    std::size_t summed_frames_ = 0;            ///< frames that the sums hold, the newest ones
    std::size_t unchanged_frames_ = 0;         ///< newest frames with one source position and scene
    std::vector<std::vector<Deposit>> spare_;  ///< memory of a forgotten frame
    std::deque<Frame> log_;                    ///< newest last; may be shorter than summed_frames_
};

}  // namespace aula
