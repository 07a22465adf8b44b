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

// From this size on, memory is mapped.
constexpr std::size_t kLarge_bytes = kHugePage_bytes / 2;

/// The parts of a block, both multiples of the page size of any system.
struct Extent {
    std::size_t huge_bytes;  ///< whole huge pages
    std::size_t rest_bytes;  ///< what would fill at most seven eighths of a further one

    std::size_t bytes() const { return huge_bytes + rest_bytes; }
};

Extent extent(std::size_t bytes) {
    constexpr std::size_t kPage_bytes = std::size_t{64} << 10;
    Extent parts{bytes / kHugePage_bytes * kHugePage_bytes, bytes % kHugePage_bytes};
    if (parts.rest_bytes > kHugePage_bytes / 8 * 7) {
        parts.huge_bytes += kHugePage_bytes;
        parts.rest_bytes = 0;
    }
    parts.rest_bytes = (parts.rest_bytes + kPage_bytes - 1) / kPage_bytes * kPage_bytes;
    return parts;
}

/// Maps huge pages, and small ones that the kernel never replaces. The heap would return memory
/// that is already backed by small pages: the kernel replaces them later, and a thread that reads
/// them then waits.
void* map_pages(const Extent& parts) {
    const std::size_t mapped = parts.bytes() + kHugePage_bytes;
    void* const block =
        mmap(nullptr, mapped, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (block == MAP_FAILED) throw std::bad_alloc();
    auto* const begin = static_cast<std::byte*>(block);
    const std::size_t before = -reinterpret_cast<std::uintptr_t>(begin) % kHugePage_bytes;
    std::byte* const first = begin + before;
    if (before > 0) munmap(begin, before);
    munmap(first + parts.bytes(), kHugePage_bytes - before);
    // Optional: only speed and waits depend on the pages.
    if (parts.huge_bytes > 0) madvise(first, parts.huge_bytes, MADV_HUGEPAGE);
    if (parts.rest_bytes > 0) {
        madvise(first + parts.huge_bytes, parts.rest_bytes, MADV_NOHUGEPAGE);
    }
    return first;
}

#endif

}  // namespace

void* allocate_aligned(std::size_t bytes) {
#if defined(__linux__)
    if (bytes >= kLarge_bytes) return map_pages(extent(bytes));
#endif
    return ::operator new (bytes, std::align_val_t{kAlignment_bytes});
}

void free_aligned(void* p, std::size_t bytes) noexcept {
#if defined(__linux__)
    if (bytes >= kLarge_bytes) {
        munmap(p, extent(bytes).bytes());
        return;
    }
#endif
    ::operator delete (p, std::align_val_t{kAlignment_bytes});
}

}  // namespace aula
