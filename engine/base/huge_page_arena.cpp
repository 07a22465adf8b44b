#include "engine/base/huge_page_arena.h"

#include <algorithm>
#include <cassert>
#include <utility>

#include "process/pages.h"

namespace aula {

namespace {

constexpr std::size_t kMax = kHugePage_bytes / sizeof(float);
constexpr std::size_t kAligned = 64 / sizeof(float);  // cache lines
constexpr std::size_t kFirst = kMax / 8;              // enough for small scenes
constexpr std::size_t kPages = kMax / 32;             // map_pages() maps multiples of them

}  // namespace

void HugePageArena::Unmap::operator()(float* block) const { unmap_pages(block, bytes); }

float* HugePageArena::take(std::size_t count) {
    assert(count <= kMax);
    count = (count + kAligned - 1) / kAligned * kAligned;
    const std::lock_guard lock(mutex_);
    if (size_ - used_ < count) {
        const std::size_t least =
            std::max(count, blocks_.empty() ? kFirst : std::min(2 * size_, kMax));
        const std::size_t size = (least + kPages - 1) / kPages * kPages;
        const std::size_t bytes = size * sizeof(float);
        void* const begin = size == kMax ? map_pages(bytes, 0) : map_pages(0, bytes);
        Block block(static_cast<float*>(begin), Unmap{bytes});
        blocks_.push_back(std::move(block));
        size_ = size;
        used_ = 0;
    }
    // New mappings are zero.
    float* const row = blocks_.back().get() + used_;
    used_ += count;
    return row;
}

}  // namespace aula
