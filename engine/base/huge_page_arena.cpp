#include "engine/base/huge_page_arena.h"

#include <sys/mman.h>

#include <algorithm>
#include <cassert>
#include <new>

namespace aula {

namespace {

constexpr std::size_t kLargePage = std::size_t{2} << 20;
constexpr std::size_t kMax = kLargePage / sizeof(std::int64_t);
constexpr std::size_t kAligned = 64 / sizeof(std::int64_t);  // cache lines
constexpr std::size_t kFirst = kMax / 8;                     // enough for small scenes

}  // namespace

std::int64_t* HugePageArena::take(std::size_t count) {
    assert(count <= kMax);
    count = (count + kAligned - 1) / kAligned * kAligned;
    const std::lock_guard lock(mutex_);
    if (size_ - used_ < count) {
        size_ = std::max(count, blocks_.empty() ? kFirst : std::min(2 * size_, kMax));
        const std::size_t alignment = size_ == kMax ? kLargePage : 64;
        const std::size_t bytes = (size_ * sizeof(std::int64_t) + 63) / 64 * 64;
        void* block = std::aligned_alloc(alignment, bytes);
        if (block == nullptr) throw std::bad_alloc();
        // Optional: only the speed depends on huge pages.
        if (size_ == kMax) madvise(block, kLargePage, MADV_HUGEPAGE);
        blocks_.emplace_back(static_cast<std::int64_t*>(block));
        used_ = 0;
    }
    std::int64_t* row = blocks_.back().get() + used_;
    used_ += count;
    std::fill_n(row, count, 0);
    return row;
}

}  // namespace aula
