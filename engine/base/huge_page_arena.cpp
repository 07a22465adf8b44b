#include "engine/base/huge_page_arena.h"

#include <sys/mman.h>

#include <algorithm>
#include <cassert>
#include <new>

namespace aula {

namespace {

constexpr std::size_t kHugePage = std::size_t{2} << 20;
constexpr std::size_t kMax = kHugePage / sizeof(float);
constexpr std::size_t kAligned = 64 / sizeof(float);  // cache lines
constexpr std::size_t kFirst = kMax / 8;              // enough for small scenes

}  // namespace

void HugePageArena::Unmap::operator()(float* block) const { munmap(block, bytes); }

HugePageArena::Block HugePageArena::map(std::size_t bytes) {
    void* const block =
        mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (block == MAP_FAILED) throw std::bad_alloc();
    return Block(static_cast<float*>(block), Unmap{bytes});
}

HugePageArena::Block HugePageArena::map_huge_page() {
    // Twice the size contains an aligned page; the parts before and after it are unmapped.
    Block whole = map(2 * kHugePage);
    auto* const begin = reinterpret_cast<std::byte*>(whole.release());
    const std::size_t before = -reinterpret_cast<std::uintptr_t>(begin) % kHugePage;
    if (before > 0) munmap(begin, before);
    munmap(begin + before + kHugePage, kHugePage - before);
    // Optional: only the speed depends on huge pages.
    madvise(begin + before, kHugePage, MADV_HUGEPAGE);
    return Block(reinterpret_cast<float*>(begin + before), Unmap{kHugePage});
}

float* HugePageArena::take(std::size_t count) {
    assert(count <= kMax);
    count = (count + kAligned - 1) / kAligned * kAligned;
    const std::lock_guard lock(mutex_);
    if (size_ - used_ < count) {
        const std::size_t size =
            std::max(count, blocks_.empty() ? kFirst : std::min(2 * size_, kMax));
        blocks_.push_back(size == kMax ? map_huge_page() : map(size * sizeof(float)));
        size_ = size;
        used_ = 0;
    }
    // New mappings are zero.
    float* const row = blocks_.back().get() + used_;
    used_ += count;
    return row;
}

}  // namespace aula
