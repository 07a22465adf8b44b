#pragma once

#include <cstddef>
#include <vector>

namespace aula {

/// Alignment of all buffers of transforms and vector loops: a cache line, and the widest vector
/// register.
inline constexpr std::size_t kAlignment_bytes = 64;

/// Memory for AlignedAllocator. Large allocations use huge pages if available, which reduces TLB
/// misses when spectra are streamed. Throws std::bad_alloc.
void* allocate_aligned(std::size_t bytes);
void free_aligned(void* p, std::size_t bytes) noexcept;

template <typename T>
struct AlignedAllocator {
    using value_type = T;

    AlignedAllocator() = default;
    template <typename U>
    AlignedAllocator(const AlignedAllocator<U>&) noexcept {}

    T* allocate(std::size_t n) { return static_cast<T*>(allocate_aligned(n * sizeof(T))); }
    void deallocate(T* p, std::size_t n) noexcept { free_aligned(p, n * sizeof(T)); }
    friend bool operator==(const AlignedAllocator&, const AlignedAllocator&) { return true; }
};

template <typename T>
using AlignedVector = std::vector<T, AlignedAllocator<T>>;

}  // namespace aula
