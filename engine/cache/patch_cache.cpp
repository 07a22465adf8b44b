#include "engine/cache/patch_cache.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>

#include "engine/base/band_vector.h"
#include "engine/base/multiversion.h"

namespace aula {

namespace {

/// A frame is valid while emitter and scene are within this share of the patch size of their
/// positions in it. At 1.5 m/s, 30 frames a second and patches of 0.5 m it is the present one
/// alone: a pair's ResponseFollower averages over more of them where the response allows it, and
/// follows changes, which older frames would only delay.
constexpr double kReach = 0.06;

/// Clearing all sums costs as much as removing this number of frames.
constexpr std::size_t kClearing = 2;

constexpr std::size_t kAxes = RowPool::kAxes;
constexpr std::size_t kPrefetchDistance = 28;  // deposits

/// Adds energies, or removes them (sign -1).
inline void add_energy(const BandSums& units, std::int64_t sign, std::int64_t* sums) {
    BandSums sum;
    std::memcpy(&sum, sums, sizeof sum);
    sum = sign > 0 ? sum + units : sum - units;
    std::memcpy(sums, &sum, sizeof sum);
}

/// Sets the sums of a row to zero.
void zero(const PatchCache::Row& row) {
    if (row.first_bin >= row.end_bin) return;
    const std::size_t bins = row.end_bin - row.first_bin;
    std::fill_n(row.sum + row.first_bin * kBandCount, bins * kBandCount, 0);
    if (row.intensity) std::fill_n(row.intensity + row.first_bin * kAxes, bins * kAxes, 0);
}

/// Adds the intensity of energy from one direction, or removes it (sign -1).
inline void add_intensity(const BandSums& units, const Vec3& departure, std::int64_t sign,
                          std::int64_t* intensity) {
    std::int64_t all = 0;
    for (std::size_t b = 0; b < kBandCount; ++b) all += units[b];
    for (std::size_t axis = 0; axis < kAxes; ++axis) {
        // rint() is an instruction where llrint() is a call.
        intensity[axis] +=
            sign * static_cast<std::int64_t>(std::rint(static_cast<double>(all) *
                                                       double{departure[static_cast<int>(axis)]}));
    }
}

}  // namespace

double PatchCache::State::moved_m(const State& older) const {
    return double{glm::distance(emitter, older.emitter)} + travel_m - older.travel_m;
}

PatchCache::PatchCache(std::size_t bin_count, int window_frames, float patch_size_m,
                       std::size_t memory_bytes, bool directed, std::shared_ptr<RowPool> memory)
    : bin_count_(bin_count),
      window_frames_(static_cast<std::size_t>(window_frames)),
      patch_size_m_(patch_size_m),
      memory_bytes_(memory_bytes),
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
        memory->give_back(row.sum, row.intensity, row.first_bin, row.end_bin);
    rows.clear();
}

std::size_t PatchCache::row_bytes(std::size_t bin_count, bool directed) {
    return bin_count * (kBandCount + (directed ? kAxes : 0)) * sizeof(std::int64_t);
}

std::size_t PatchCache::bytes_of(const std::vector<Batch>& batches) {
    std::size_t sum = 0;
    for (const Batch& batch : batches) {
        sum += batch.deposits.memory_bytes() + batch.departures.capacity() * sizeof(Vec3);
    }
    return sum;
}

bool PatchCache::complete() const { return emitted_ >= kEnoughRays && is_current(); }

void PatchCache::advance(const State& now, bool wanted, WorkerPool& workers) {
    const bool changed = now.changed_since(now_);
    now_ = now;
    if (summed_frames_ == 0) return;
    if (changed) fresh_frames_ = 0;
    // The oldest of the frames before the last change are removed first.
    std::size_t keep = fresh_frames_;
    while (wanted && keep < std::min(summed_frames_, log_.size()) &&
           holds(log_[log_.size() - 1 - keep])) {
        ++keep;
    }
    if (summed_frames_ > log_.size()) keep = std::min(keep, std::max(fresh_frames_, kKeptAtStart));
    if (keep < summed_frames_) keep_newest(keep, workers);
    forget_aged();
    assert(is_consistent());
}

/// Frees logged frames that no change can keep because they are older than the window. Without
/// frames from before the last change, none of them has to be removed from the sums one by one.
void PatchCache::forget_aged() {
    if (!is_current()) return;
    while (!log_.empty() && now_.frame - log_.front().state.frame >= window_frames_) {
        spare_ = std::move(log_.front().batches);
        log_.pop_front();
    }
    if (log_.empty()) spare_ = {};
}

bool PatchCache::holds(const Frame& frame) const {
    const std::uint64_t age = now_.frame - frame.state.frame;
    if (age >= window_frames_) return false;
    const double moved_m = now_.moved_m(frame.state);
    return moved_m <= kReach * double{patch_size_m_};
}

void PatchCache::keep_newest(std::size_t frames, WorkerPool& workers) {
    assert(frames <= log_.size());
    if (frames == 0) {
        table_.clear();
        allocated_rows_ = 0;
        emitted_ = 0;
    } else if (summed_frames_ <= log_.size() && summed_frames_ - frames <= frames + kClearing) {
        for (std::size_t i = log_.size() - summed_frames_; i < log_.size() - frames; ++i) {
            apply(log_[i], -1, workers);
        }
    } else {
        // Most frames are removed, or frames older than the log: rebuild the sums from the
        // remaining ones.
        clear_sums(workers);
        emitted_ = 0;
        for (std::size_t i = log_.size() - frames; i < log_.size(); ++i) {
            apply(log_[i], 1, workers);
        }
    }
    summed_frames_ = frames;
    fresh_frames_ = std::min(fresh_frames_, frames);
    if (frames < log_.size()) spare_ = std::move(log_.front().batches);
    log_.erase(log_.begin(), log_.end() - static_cast<std::ptrdiff_t>(frames));
}

void PatchCache::add_frame(int rays, std::size_t patch_count, std::span<DepositBatch> batches,
                           WorkerPool& workers) {
    if (table_.rows.size() < patch_count) table_.rows.resize(patch_count);
    Frame frame{now_, static_cast<std::uint64_t>(rays), std::move(spare_)};
    frame.batches.resize(batches.size());
    for (std::size_t i = 0; i < batches.size(); ++i) {
        std::swap(frame.batches[i].deposits, batches[i].deposits);
        if (directed_) std::swap(frame.batches[i].departures, batches[i].departures);
    }
    apply(frame, 1, workers);
    log_.push_back(std::move(frame));
    ++summed_frames_;
    ++fresh_frames_;
    // While nothing changes, each new frame replaces one from before the change. The window then
    // grows with valid frames only.
    if (fresh_frames_ == 1) window_then_ = summed_frames_;
    const std::size_t max = std::max(fresh_frames_, window_then_);
    if (summed_frames_ > max) keep_newest(max, workers);
    trim_log(workers);
    assert(is_consistent());
}

/// Removes logged frames that cannot be needed, and the oldest that exceed the memory. Frames in
/// the sums from before the last change stay logged or are removed from the sums, because without
/// the log they could not be removed later. Removing newer ones of the sums counts as a change.
void PatchCache::trim_log(WorkerPool& workers) {
    if (log_.size() > window_frames_) {
        spare_ = std::move(log_.front().batches);
        log_.pop_front();
    }
    std::size_t bytes = table_bytes() + bytes_of(spare_);
    std::size_t kept = 0;
    for (; kept < log_.size(); ++kept) {
        bytes += bytes_of(log_[log_.size() - 1 - kept].batches);
        if (bytes > memory_bytes_) break;
    }
    if (!is_current() && kept < summed_frames_) keep_newest(std::max(fresh_frames_, kept), workers);
    if (kept < log_.size()) {
        log_.erase(log_.begin(), log_.end() - static_cast<std::ptrdiff_t>(kept));
    }
}

void PatchCache::apply(const Frame& frame, std::int64_t sign, WorkerPool& workers) {
    std::array<std::size_t, DepositParts::kCount> allocated{};
    workers.run(allocated.size(), [&](std::size_t part) {
        for (const Batch& batch : frame.batches) allocated[part] += apply_batch(batch, part, sign);
        for (std::size_t patch = part; sign < 0 && patch < table_.rows.size();
             patch += DepositParts::kCount) {
            trim(table_.rows[patch]);
        }
    });
    for (const std::size_t more : allocated) allocated_rows_ += more;
    emitted_ += static_cast<std::uint64_t>(sign) * frame.rays;
}

/// Adds or removes the deposits on one part of the patches; returns the number of new rows.
AULA_MULTIVERSION
std::size_t PatchCache::apply_batch(const Batch& batch, std::size_t part, std::int64_t sign) {
    std::size_t allocated = 0;
    const std::vector<Deposit>& deposits = batch.deposits.part[part];
    for (std::size_t i = 0; i < deposits.size(); ++i) {
        // Prefetch: sums are scattered in memory.
        if (i + kPrefetchDistance < deposits.size()) {
            const Deposit& soon = deposits[i + kPrefetchDistance];
            const Row& row = table_.rows[soon.patch];
            if (row.sum) __builtin_prefetch(&row.sum[soon.bin * kBandCount], 1);
            if (row.intensity) __builtin_prefetch(&row.intensity[soon.bin * kAxes], 1);
        }
        const Deposit& deposit = deposits[i];
        Row& row = table_.rows[deposit.patch];
        if (!row.sum) {
            row.sum = table_.memory->take_sums();
            if (directed_) row.intensity = table_.memory->take_intensities();
            ++allocated;
        }
        row.deposits += static_cast<std::uint64_t>(sign);
        row.first_bin = std::min<std::uint32_t>(row.first_bin, deposit.bin);
        row.end_bin = std::max<std::uint32_t>(row.end_bin, deposit.bin + 1U);
        const BandSums units = deposit.units();
        add_energy(units, sign, &row.sum[deposit.bin * kBandCount]);
        if (directed_) {
            add_intensity(units, batch.departures[deposit.ray], sign,
                          &row.intensity[deposit.bin * kAxes]);
        }
    }
    return allocated;
}

/// Sets all sums to zero.
void PatchCache::clear_sums(WorkerPool& workers) {
    workers.run(DepositParts::kCount, [&](std::size_t part) {
        for (std::size_t patch = part; patch < table_.rows.size(); patch += DepositParts::kCount) {
            Row& row = table_.rows[patch];
            zero(row);
            row.deposits = 0;
            row.first_bin = ~0U;
            row.end_bin = 0;
        }
    });
}

/// Removes empty bins at both ends. After a removal the row, and every value computed from it, is
/// then bit-identical to one without the removed deposits.
void PatchCache::trim(Row& row) const {
    const auto empty = [&](std::uint32_t bin) {
        const std::int64_t* sum = &row.sum[bin * kBandCount];
        return std::all_of(sum, sum + kBandCount, [](std::int64_t energy) { return energy == 0; });
    };
    while (row.first_bin < row.end_bin && empty(row.first_bin)) ++row.first_bin;
    while (row.first_bin < row.end_bin && empty(row.end_bin - 1)) --row.end_bin;
    if (row.first_bin >= row.end_bin) {
        row.first_bin = ~0U;
        row.end_bin = 0;
    }
}

/// The invariant of the counters; for assert().
bool PatchCache::is_consistent() const {
    if (fresh_frames_ > summed_frames_ || log_.size() > std::min(summed_frames_, window_frames_)) {
        return false;
    }
    if (!is_current() && log_.size() < summed_frames_) return false;
    if (fresh_frames_ > 0 && summed_frames_ > std::max(fresh_frames_, window_then_)) return false;
    std::uint64_t logged_rays = 0;
    for (const Frame& frame : log_) logged_rays += frame.rays;
    if (log_.size() == summed_frames_ ? emitted_ != logged_rays : emitted_ < logged_rays) {
        return false;
    }
    return allocated_rows_ ==
           static_cast<std::size_t>(std::count_if(table_.rows.begin(), table_.rows.end(),
                                                  [](const Row& row) { return row.sum; }));
}

std::size_t PatchCache::occupied() const {
    return static_cast<std::size_t>(std::count_if(table_.rows.begin(), table_.rows.end(),
                                                  [](const Row& row) { return row.deposits > 0; }));
}

std::size_t PatchCache::table_bytes() const {
    return table_.rows.capacity() * sizeof(Row) +
           allocated_rows_ * row_bytes(bin_count_, directed_);
}

std::size_t PatchCache::memory_bytes() const {
    std::size_t bytes = table_bytes() + bytes_of(spare_);
    for (const Frame& frame : log_) bytes += bytes_of(frame.batches);
    return bytes;
}

}  // namespace aula
