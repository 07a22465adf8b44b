#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <mutex>
#include <vector>

namespace aula {

/// Memory for rows of sums, on huge pages: rows are accessed in random order, which would cause TLB
/// misses with small pages. All rows are freed together.
class HugePageArena {
 public:
    /// `count` zeros, aligned to 64 bytes; `count` <= 2^18. Throws std::bad_alloc. [any thread]
    std::int64_t* take(std::size_t count);

 private:
    struct Free {
        void operator()(std::int64_t* block) const { std::free(block); }
    };

    std::mutex mutex_;
    std::vector<std::unique_ptr<std::int64_t[], Free>> blocks_;
    std::size_t size_ = 0;  ///< numbers in the last block
    std::size_t used_ = 0;  ///< numbers of it in use
};

}  // namespace aula
