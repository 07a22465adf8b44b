#include "audio/base/aligned.h"

#include <new>

#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace aula {

namespace {

constexpr std::size_t kHugePage_bytes = std::size_t{2} << 20;

// From this size on, rounding up to whole huge pages at most doubles the memory.
constexpr std::size_t kLarge_bytes = kHugePage_bytes / 2;

struct Layout {
    std::size_t bytes;
    std::align_val_t alignment;
};

Layout layout_of(std::size_t bytes) {
    if (bytes < kLarge_bytes) return {bytes, std::align_val_t{kAlignment_bytes}};
    return {(bytes + kHugePage_bytes - 1) / kHugePage_bytes * kHugePage_bytes,
            std::align_val_t{kHugePage_bytes}};
}

}  // namespace

void* allocate_aligned(std::size_t bytes) {
    const Layout layout = layout_of(bytes);
    void* const p = ::operator new(layout.bytes, layout.alignment);
#if defined(__linux__)
    // Optional: only the speed depends on huge pages.
    if (bytes >= kLarge_bytes) madvise(p, layout.bytes, MADV_HUGEPAGE);
#endif
    return p;
}

void free_aligned(void* p, std::size_t bytes) noexcept {
    ::operator delete(p, layout_of(bytes).alignment);
}

}  // namespace aula
