#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <mutex>
#include <vector>

namespace aula {

/// Memory for rows of sums. Sums are met in no order, so that each would wait for its page to be
/// looked up; large pages are so few that the processor knows them all. Freed together.
class HugePageArena {
 public:
    /// Zeros, aligned to 64 bytes; `count` <= 2^18. May be called by several threads at once.
    std::int64_t* take(std::size_t count);

 private:
    struct Free {
        void operator()(std::int64_t* block) const { std::free(block); }
    };

    std::mutex mutex_;
    std::vector<std::unique_ptr<std::int64_t[], Free>> blocks_;
    std::size_t size_ = 0;  ///< of the last block, in numbers
    std::size_t used_ = 0;  ///< of it
};

}  // namespace aula
