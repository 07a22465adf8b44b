#include "audio/base/aligned.h"

#include <new>

#include "process/pages.h"

namespace aula {

namespace {

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

}  // namespace

void* allocate_aligned(std::size_t bytes) {
    if (bytes < kLarge_bytes) return ::operator new (bytes, std::align_val_t{kAlignment_bytes});
    const Extent parts = extent(bytes);
    return map_pages(parts.huge_bytes, parts.rest_bytes);
}

void free_aligned(void* p, std::size_t bytes) noexcept {
    if (bytes >= kLarge_bytes)
        unmap_pages(p, extent(bytes).bytes());
    else
        ::operator delete (p, std::align_val_t{kAlignment_bytes});
}

}  // namespace aula
