#include "audio/base/aligned.h"

#include <cstdint>
#include <new>

#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace aula {

namespace {

#if defined(__linux__)

constexpr std::size_t kHugePage_bytes = std::size_t{2} << 20;

// From this size on, rounding up to whole huge pages at most doubles the memory.
constexpr std::size_t kLarge_bytes = kHugePage_bytes / 2;

std::size_t whole_huge_pages(std::size_t bytes) {
    return (bytes + kHugePage_bytes - 1) / kHugePage_bytes * kHugePage_bytes;
}

/// Maps whole huge pages. The heap would return memory that is already backed by small pages: the
/// kernel replaces them later, and a thread that reads them then waits.
void* map_huge_pages(std::size_t bytes) {
    const std::size_t mapped = bytes + kHugePage_bytes;
    void* const block =
        mmap(nullptr, mapped, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (block == MAP_FAILED) throw std::bad_alloc();
    auto* const begin = static_cast<std::byte*>(block);
    const std::size_t before = -reinterpret_cast<std::uintptr_t>(begin) % kHugePage_bytes;
    if (before > 0) munmap(begin, before);
    munmap(begin + before + bytes, kHugePage_bytes - before);
    // Optional: only the speed depends on huge pages.
    madvise(begin + before, bytes, MADV_HUGEPAGE);
    return begin + before;
}

#endif

}  // namespace

void* allocate_aligned(std::size_t bytes) {
#if defined(__linux__)
    if (bytes >= kLarge_bytes) return map_huge_pages(whole_huge_pages(bytes));
#endif
    return ::operator new (bytes, std::align_val_t{kAlignment_bytes});
}

void free_aligned(void* p, std::size_t bytes) noexcept {
#if defined(__linux__)
    if (bytes >= kLarge_bytes) {
        munmap(p, whole_huge_pages(bytes));
        return;
    }
#endif
    ::operator delete (p, std::align_val_t{kAlignment_bytes});
}

}  // namespace aula
