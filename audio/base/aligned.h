#pragma once

#include <cstddef>
#include <vector>

namespace aula {

/// Alignment of all buffers that transforms and vector loops run over: a cache line, which is also
/// the widest vector register.
inline constexpr std::size_t kAlignment_bytes = 64;

/// Memory for AlignedAllocator. Large pieces lie on huge pages where the system has them: streaming
/// through spectra would otherwise be held up by the translation of addresses.
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
