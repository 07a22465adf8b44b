#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

namespace aula {

/// Memory for rows of sums, on huge pages: rows are accessed in random order, which would cause TLB
/// misses with small pages. All rows are freed together.
///
/// The memory is mapped, not allocated: the heap returns memory that is already backed by small
/// pages, which the kernel does not replace.
class HugePageArena {
 public:
    /// `count` zeros, aligned to 64 bytes; `count` <= 2^19. Throws std::bad_alloc. [any thread]
    float* take(std::size_t count);

 private:
    struct Unmap {
        std::size_t bytes = 0;

        void operator()(float* block) const;
    };
    using Block = std::unique_ptr<float[], Unmap>;

    std::mutex mutex_;
    std::vector<Block> blocks_;
    std::size_t size_ = 0;  ///< numbers in the last block
    std::size_t used_ = 0;  ///< numbers of it in use
};

}  // namespace aula
