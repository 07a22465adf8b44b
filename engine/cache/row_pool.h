#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <vector>

#include "engine/base/huge_page_arena.h"

namespace aula {

/// Memory for the rows of patch caches. A row that one cache gives back serves the next one that
/// needs a row. A change of the emitting end therefore maps no memory: the first use of a huge page
/// takes 0.2 ms, and several where the host of a virtual machine has to provide it. reserve() maps
/// memory before it is needed. [any thread]
class RowPool {
 public:
    /// Rows of `bin_count` time bins.
    explicit RowPool(std::size_t bin_count);

    /// Zeros: [bin][band].
    float* take_sums() { return sums_.take(*this); }
    /// Zeros: [bin][moment], kMoments.
    float* take_directions() { return directions_.take(*this); }

    /// Takes back rows that are zero outside the bins [first_bin, end_bin). Null is ignored. They
    /// are cleared by reserve(), or when they are taken.
    void give_back(float* sums, float* directions, std::size_t first_bin, std::size_t end_bin);

    /// Maps rows of at most `most_bytes`, as long as fewer than this number of rows is free, and
    /// clears rows that have been given back, of a quarter as many bytes.
    void reserve(std::size_t sums, std::size_t directions, std::size_t most_bytes);

    /// Bytes of the rows that no cache uses.
    std::size_t free_bytes() const;

    static constexpr std::size_t kMoments = 8;  ///< those of DirectionMoments

 private:
    /// A row that is zero outside these numbers.
    struct UsedRow {
        float* row;
        std::size_t first;
        std::size_t end;
        void clear() const { std::fill(row + first, row + end, 0); }
    };
    /// Rows of one size.
    struct Rows {
        std::size_t width = 0;  ///< numbers in a bin
        std::size_t bins = 0;
        std::vector<float*> free{};   ///< zeros
        std::vector<UsedRow> used{};  ///< not yet cleared

        float* take(RowPool& memory);
        void give_back(float* row, std::size_t first_bin, std::size_t end_bin);
        std::size_t size() const { return width * bins; }
        std::size_t bytes() const { return size() * sizeof(float); }
        std::size_t free_bytes() const { return (free.size() + used.size()) * bytes(); }
        void clear(std::size_t& bytes_left);
        void reserve(std::size_t rows, std::size_t& bytes_left, HugePageArena& arena);
    };

    mutable std::mutex mutex_;
    HugePageArena arena_;
    Rows sums_;
    Rows directions_;
};

}  // namespace aula
