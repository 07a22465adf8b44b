#include "engine/cache/row_pool.h"

#include "aula/engine/bands.h"

namespace aula {

namespace {

/// Numbers in a page of memory of 4 KiB, the smallest of all systems.
constexpr std::size_t kPage = 4096 / sizeof(float);

/// Of the bytes that are mapped in a call at most. A choice: a page is cleared when it is mapped,
/// too, and rows that are needed before are cleared then.
constexpr std::size_t kClearedPart = 4;

/// Lets the kernel provide the memory of zeros that have not been used yet.
void touch(float* row, std::size_t size) {
    for (std::size_t i = 0; i < size; i += kPage) {
        *const_cast<volatile float*>(row + i) = 0;
    }
    *const_cast<volatile float*>(row + size - 1) = 0;
}

}  // namespace

RowPool::RowPool(std::size_t bin_count)
    : sums_{kBandCount, bin_count}, directions_{kMoments, bin_count} {}

float* RowPool::Rows::take(RowPool& memory) {
    std::unique_lock lock(memory.mutex_);
    if (!free.empty()) {
        float* const row = free.back();
        free.pop_back();
        return row;
    }
    if (used.empty()) return memory.arena_.take(size());
    const UsedRow newest = used.back();
    used.pop_back();
    lock.unlock();
    newest.clear();
    return newest.row;
}

void RowPool::Rows::give_back(float* row, std::size_t first_bin, std::size_t end_bin) {
    if (!row) return;
    if (first_bin < end_bin) {
        used.push_back({row, first_bin * width, end_bin * width});
    } else {
        free.push_back(row);
    }
}

void RowPool::give_back(float* sums, float* directions, std::size_t first_bin,
                        std::size_t end_bin) {
    const std::lock_guard lock(mutex_);
    sums_.give_back(sums, first_bin, end_bin);
    directions_.give_back(directions, first_bin, end_bin);
}

void RowPool::Rows::clear(std::size_t& bytes_left) {
    while (!used.empty() && bytes_left >= bytes()) {
        used.back().clear();
        free.push_back(used.back().row);
        used.pop_back();
        bytes_left -= bytes();
    }
}

void RowPool::Rows::reserve(std::size_t rows, std::size_t& bytes_left, HugePageArena& arena) {
    while (free.size() + used.size() < rows && bytes_left >= bytes()) {
        free.push_back(arena.take(size()));
        touch(free.back(), size());
        bytes_left -= bytes();
    }
}

void RowPool::reserve(std::size_t sums, std::size_t directions, std::size_t most_bytes) {
    const std::lock_guard lock(mutex_);
    std::size_t most_cleared_bytes = most_bytes / kClearedPart;
    sums_.clear(most_cleared_bytes);
    directions_.clear(most_cleared_bytes);
    sums_.reserve(sums, most_bytes, arena_);
    directions_.reserve(directions, most_bytes, arena_);
}

std::size_t RowPool::free_bytes() const {
    const std::lock_guard lock(mutex_);
    return sums_.free_bytes() + directions_.free_bytes();
}

}  // namespace aula
