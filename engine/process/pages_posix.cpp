#include <sys/mman.h>

#include <cstdint>
#include <new>

#include "process/pages.h"

namespace aula {

void* map_pages(std::size_t huge_bytes, std::size_t rest_bytes) {
    const std::size_t bytes = huge_bytes + rest_bytes;
    // One page more contains an aligned block; the parts before and after it are unmapped.
    void* const block = mmap(nullptr, bytes + kHugePage_bytes, PROT_READ | PROT_WRITE,
                             MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (block == MAP_FAILED) throw std::bad_alloc();
    auto* const begin = static_cast<std::byte*>(block);
    const std::size_t before = -reinterpret_cast<std::uintptr_t>(begin) % kHugePage_bytes;
    std::byte* const first = begin + before;
    if (before > 0) munmap(begin, before);
    munmap(first + bytes, kHugePage_bytes - before);
    // Optional: only speed and waits depend on the pages.
#ifdef MADV_HUGEPAGE
    if (huge_bytes > 0) madvise(first, huge_bytes, MADV_HUGEPAGE);
    if (rest_bytes > 0) madvise(first + huge_bytes, rest_bytes, MADV_NOHUGEPAGE);
#endif
    return first;
}

void unmap_pages(void* begin, std::size_t bytes) noexcept { munmap(begin, bytes); }

}  // namespace aula
