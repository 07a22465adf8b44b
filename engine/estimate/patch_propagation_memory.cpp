#include "engine/estimate/patch_propagation.h"

#include <algorithm>

namespace aula {

namespace {

/// Share of the cache memory for segments that end in mirrors; the sums have the rest. A choice: of
/// the default memory of 256 MB they have space for 270,000, twice kMaxSegments for sources and for
/// listeners.
constexpr double kSegmentShare = 0.1;

/// The grid has at least this number of patches, whatever the memory. A choice: about three for
/// each side of a box.
constexpr double kFewestRows = 16;

/// Segments of all sources, or listeners, together. A choice: while receivers move, each frame
/// searches them all, 16 at a time.
constexpr std::size_t kMaxSegments = 1 << 16;

/// Memory that is mapped in a frame for the end that emits next: a huge page of x86-64 and AArch64.
constexpr std::size_t kReserved_bytes = std::size_t{2} << 20;

}  // namespace

double PatchPropagation::max_rows(double memory_bytes, const TimeBins& bins,
                                  std::size_t source_count, std::size_t listener_count) {
    const std::size_t bytes = source_count * PatchCache::row_bytes(bins.count(), false) +
                              listener_count * PatchCache::row_bytes(bins.count(), true);
    return std::max(kFewestRows, (1 - kSegmentShare) * memory_bytes / static_cast<double>(bytes));
}

std::size_t PatchPropagation::max_segments(bool directed) const {
    return kMaxSegments / (directed ? listener_count_ : source_count());
}

std::size_t PatchPropagation::segment_bytes() const {
    return static_cast<std::size_t>(kSegmentShare * memory_bytes_ /
                                    static_cast<double>(emitter_count()));
}

/// An emitter without rays; divide_segments() bounds its segments.
PatchPropagation::End PatchPropagation::make_end(std::size_t id, bool directed) const {
    End end{
        id,
        PatchCache(bins_.count(), directed, row_pool_),
        SegmentCache(window_frames_, listener_radius_m_, gather_settings_.attenuation_per_m, 0, 0),
        {},
        {},
        {},
        {}};
    if (!directed) {
        const EnergyResponse silent = EnergyResponse::silent(bins_, speed_of_sound_m_s_);
        end.pairs.assign(listener_count_, {silent, window_frames_});
    }
    return end;
}

/// Divides the segments among the emitters after their number has changed.
void PatchPropagation::divide_segments() {
    for (std::size_t e = 0; e < emitter_count(); ++e)
        ends_[e].segments.set_bounds(max_segments(e >= source_count()), segment_bytes());
}

/// Maps memory for the end that emits after the next change, a little in each frame without a
/// change: those during one and after one cost more already. Clears rows in every frame.
void PatchPropagation::reserve_rows(std::uint64_t frame) {
    if (from_listeners_) return;  // the emitting end does not change
    const bool changed =
        std::any_of(ends_.begin(), ends_.end(), [](const End& end) { return end.status.changed; });
    if (changed || scene_moved_recently(frame)) {
        row_pool_->reserve(0, 0, kReserved_bytes);
        return;
    }
    std::size_t used = 0;
    std::size_t used_by_listeners = 0;
    std::size_t most = 0;
    for (std::size_t e = 0; e < emitter_count(); ++e) {
        const std::size_t rows = ends_[e].cache.allocated_rows();
        used += rows;
        if (e >= source_count()) used_by_listeners += rows;
        most = std::max(most, rows);
    }
    // No more than the rows of all emitters, which the limit of the memory allows. A cache can have
    // more than the reached patches have: rays hit some that the search for them has missed.
    const std::size_t each = std::max(grid_.reached_rows(), most);
    const auto reserved = [&](std::size_t emitters, std::size_t in_use) {
        return std::min(most, std::max(emitters * each, in_use) - in_use);
    };
    row_pool_->reserve(reserved(emitter_count(), used),
                       reserved(listener_count_, used_by_listeners), kReserved_bytes);
}

}  // namespace aula
