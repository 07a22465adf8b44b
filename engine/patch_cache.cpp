#include "engine/patch_cache.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace aula {

namespace {

/// 2^22 rays leave less noise than the gather has, and their sums stay below 2^63 in units of
/// 2^-34 even where each ray meets a patch a hundred times in one bin.
constexpr std::uint64_t kMostRays = 1ULL << 22;

/// A frame holds while source and scene are within this share of the patch size of where they were
/// then. At 1.5 m/s, 30 frames a second and patches of 0.5 m that is four frames, which is where
/// tracking errors of a walking source are least.
constexpr double kReach = 0.4;

/// Fewer frames are never kept, but after a jump.
constexpr std::size_t kLeastFrames = 2;
constexpr double kJump_m = 1;

}  // namespace

PatchCache::PatchCache(std::size_t bin_count, int window_frames, float patch_size_m,
                       std::size_t log_bytes)
    : bin_count_(bin_count),
      window_frames_(static_cast<std::size_t>(window_frames)),
      patch_size_m_(patch_size_m),
      log_bytes_(log_bytes) {}

std::size_t PatchCache::Frame::bytes() const {
    std::size_t count = 0;
    for (const auto& batch : deposits) count += batch.size();
    return count * sizeof(Deposit);
}

bool PatchCache::complete(const Vec3& source, double travel_m) const {
    return emitted_ >= kMostRays && !log_.empty() && log_.back().source == source &&
           log_.back().travel_m == travel_m;
}

void PatchCache::add_frame(const Vec3& source, double travel_m, int rays, std::size_t patch_count,
                           std::span<TraceBatch> batches, WorkerPool& workers) {
    if (rows_.size() < patch_count) rows_.resize(patch_count);
    Frame frame{source, travel_m, static_cast<std::uint64_t>(rays), {}};
    frame.deposits = std::move(spare_);
    frame.deposits.resize(batches.size());
    for (std::size_t i = 0; i < batches.size(); ++i) {
        std::swap(frame.deposits[i], batches[i].deposits);
    }
    const bool changed =
        !log_.empty() && (log_.back().source != source || log_.back().travel_m != travel_m);
    unchanged_frames_ = changed ? 1 : unchanged_frames_ + 1;
    log_.push_back(std::move(frame));
    apply(log_.back(), 1, workers);
    ++summed_frames_;

    if (unchanged_frames_ < summed_frames_) {
        const std::size_t keep = frames_that_hold();
        if (summed_frames_ > log_.size()) {
            // Older frames than the log holds are in the sums: begin anew with those that stay.
            for (Row& row : rows_) {
                if (row.sum) std::fill_n(row.sum.get(), bin_count_ * kBandCount, 0);
                row.first_bin = ~0U;
                row.end_bin = 0;
            }
            emitted_ = 0;
            for (std::size_t i = log_.size() - keep; i < log_.size(); ++i) {
                apply(log_[i], 1, workers);
            }
        } else {
            for (std::size_t i = log_.size() - summed_frames_; i < log_.size() - keep; ++i) {
                apply(log_[i], -1, workers);
            }
        }
        summed_frames_ = keep;
    }

    std::size_t bytes = 0;
    std::size_t kept = 0;
    for (auto logged = log_.rbegin(); logged != log_.rend() && kept < window_frames_; ++logged) {
        bytes += logged->bytes();
        if (kept > 0 && bytes > log_bytes_) break;
        ++kept;
    }
    if (kept < log_.size()) spare_ = std::move(log_.front().deposits);
    log_.erase(log_.begin(), log_.end() - static_cast<std::ptrdiff_t>(kept));
}

/// The number of newest logged frames that still hold for the newest one's source and scene.
std::size_t PatchCache::frames_that_hold() const {
    const Frame& now = log_.back();
    const std::size_t most = std::min({log_.size(), window_frames_, summed_frames_});
    std::size_t keep = 1;
    for (; keep < most; ++keep) {
        const Frame& older = log_[log_.size() - 1 - keep];
        const double moved_m =
            double{glm::distance(older.source, now.source)} + now.travel_m - older.travel_m;
        if (moved_m > kJump_m) break;
        if (keep >= kLeastFrames && moved_m > kReach * double{patch_size_m_}) break;
    }
    return keep;
}

void PatchCache::apply(const Frame& frame, std::int64_t sign, WorkerPool& workers) {
    // Each job owns the patches of one residue: no two threads touch one row.
    const auto jobs = static_cast<std::size_t>(workers.threads());
    workers.run(jobs, [&](std::size_t job) {
        for (const auto& batch : frame.deposits) {
            for (std::size_t i = 0; i < batch.size(); ++i) {
                // Sums lie scattered in memory: ask for those that come soon.
                if (const std::size_t soon = i + 8;
                    soon < batch.size() && batch[soon].patch % jobs == job) {
                    const auto& sum = rows_[batch[soon].patch].sum;
                    if (sum) __builtin_prefetch(&sum[batch[soon].bin * kBandCount], 1);
                }
                const Deposit& deposit = batch[i];
                if (deposit.patch % jobs != job) continue;
                Row& row = rows_[deposit.patch];
                if (!row.sum) {
                    row.sum = std::make_unique<std::int64_t[]>(bin_count_ * kBandCount);
                }
                row.first_bin = std::min(row.first_bin, deposit.bin);
                row.end_bin = std::max(row.end_bin, deposit.bin + 1);
                std::int64_t* sum = &row.sum[deposit.bin * kBandCount];
                for (std::size_t b = 0; b < kBandCount; ++b) {
                    sum[b] += sign * std::llrint(double{deposit.energy[b]} / kUnit);
                }
            }
        }
    });
    emitted_ += static_cast<std::uint64_t>(sign) * frame.rays;
}

std::size_t PatchCache::occupied() const {
    return static_cast<std::size_t>(
        std::count_if(rows_.begin(), rows_.end(), [](const Row& row) { return row.end_bin > 0; }));
}

std::size_t PatchCache::memory_bytes() const {
    std::size_t bytes = rows_.size() * sizeof(Row);
    for (const Row& row : rows_) {
        if (row.sum) bytes += bin_count_ * kBandCount * sizeof(std::int64_t);
    }
    for (const Frame& frame : log_) bytes += frame.bytes();
    return bytes;
}

}  // namespace aula
