#include "engine/estimate/row_pool.h"

#include <algorithm>
#include <cassert>

#include "aula/engine/bands.h"

namespace aula {

namespace {

constexpr std::size_t kPage = 4096 / sizeof(std::int64_t);

/// Lets the kernel provide the memory of zeros that have not been used yet.
void touch(std::int64_t* row, std::size_t size) {
    for (std::size_t i = 0; i < size; i += kPage) {
        *const_cast<volatile std::int64_t*>(row + i) = 0;
    }
    *const_cast<volatile std::int64_t*>(row + size - 1) = 0;
}

}  // namespace

RowPool::RowPool(std::size_t bin_count)
    : sums_{bin_count * kBandCount}, intensities_{bin_count * kAxes} {}

std::int64_t* RowPool::Rows::take(RowPool& memory) {
    const std::lock_guard lock(memory.mutex_);
    if (free.empty()) return memory.arena_.take(size);
    std::int64_t* const row = free.back();
    free.pop_back();
    return row;
}

void RowPool::give_back(std::int64_t* sums, std::int64_t* intensities) {
    const std::lock_guard lock(mutex_);
    const auto add = [](Rows& rows, std::int64_t* row) {
        if (!row) return;
        assert(std::all_of(row, row + rows.size, [](std::int64_t x) { return x == 0; }));
        rows.free.push_back(row);
    };
    add(sums_, sums);
    add(intensities_, intensities);
}

void RowPool::Rows::reserve(std::size_t rows, std::size_t& bytes_left, HugePageArena& arena) {
    while (free.size() < rows && bytes_left >= bytes()) {
        free.push_back(arena.take(size));
        touch(free.back(), size);
        bytes_left -= bytes();
    }
}

void RowPool::reserve(std::size_t sums, std::size_t intensities, std::size_t most_bytes) {
    const std::lock_guard lock(mutex_);
    sums_.reserve(sums, most_bytes, arena_);
    intensities_.reserve(intensities, most_bytes, arena_);
}

std::size_t RowPool::free_bytes() const {
    const std::lock_guard lock(mutex_);
    return sums_.free.size() * sums_.bytes() + intensities_.free.size() * intensities_.bytes();
}

}  // namespace aula
