#pragma once

#include <cstddef>

namespace aula {

inline constexpr std::size_t kHugePage_bytes = std::size_t{2} << 20;

/// Zeroed memory of the system, aligned to a cache line at least. The first part, a multiple of
/// kHugePage_bytes, is on huge pages where the system gives them to all programs; the second one,
/// a multiple of 64 KiB, is on small ones that are never replaced. The heap would return memory
/// that is already backed by small pages: the kernel replaces them later, and a thread that reads
/// them then waits. Throws std::bad_alloc. [any thread]
void* map_pages(std::size_t huge_bytes, std::size_t rest_bytes);

/// Returns such memory; `bytes` is the sum of the parts.
void unmap_pages(void* begin, std::size_t bytes) noexcept;

}  // namespace aula
