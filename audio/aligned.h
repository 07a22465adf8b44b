#pragma once

#include <cstddef>
#include <new>
#include <vector>

namespace aula {

/// Alignment of all buffers that transforms and vector loops run over: a cache line, which is also
/// the widest vector register.
inline constexpr std::size_t kAlignment_bytes = 64;

template <typename T>
struct AlignedAllocator {
    using value_type = T;

    AlignedAllocator() = default;
    template <typename U>
    AlignedAllocator(const AlignedAllocator<U>&) noexcept {}

    T* allocate(std::size_t n) {
        return static_cast<T*>(::operator new (n * sizeof(T), std::align_val_t{kAlignment_bytes}));
    }
    void deallocate(T* p, std::size_t) noexcept {
        ::operator delete (p, std::align_val_t{kAlignment_bytes});
    }
    friend bool operator==(const AlignedAllocator&, const AlignedAllocator&) { return true; }
};

template <typename T>
using AlignedVector = std::vector<T, AlignedAllocator<T>>;

}  // namespace aula
