#include "engine/estimate/row_pool.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <set>

#include "aula/engine/bands.h"

using namespace aula;

namespace {

constexpr std::size_t kBins = 100;
constexpr std::size_t kSums = kBins * kBandCount;
constexpr std::size_t kIntensities = kBins * RowPool::kAxes;

}  // namespace

TEST_CASE("memory of rows serves a row again that was given back") {
    RowPool memory(kBins);
    std::int64_t* const sums = memory.take_sums();
    std::int64_t* const intensities = memory.take_intensities();
    CHECK(std::all_of(sums, sums + kSums, [](std::int64_t x) { return x == 0; }));
    CHECK(memory.free_bytes() == 0);
    memory.give_back(sums, nullptr);
    CHECK(memory.free_bytes() == kSums * sizeof(std::int64_t));
    memory.give_back(nullptr, intensities);
    CHECK(memory.free_bytes() == (kSums + kIntensities) * sizeof(std::int64_t));
    CHECK(memory.take_intensities() == intensities);
    CHECK(memory.take_sums() == sums);
    CHECK(memory.take_sums() != sums);
    CHECK(memory.free_bytes() == 0);
}

TEST_CASE("rows are reserved up to a number, at most a given size in one call") {
    RowPool memory(kBins);
    constexpr std::size_t kMost_bytes = std::size_t{2} << 20;
    constexpr std::size_t kRows = 1000;
    constexpr std::size_t kAll = kRows * (kSums + kIntensities) * sizeof(std::int64_t);
    std::size_t before = 0;
    int calls = 0;
    for (; memory.free_bytes() < kAll && calls < 100; ++calls) {
        memory.reserve(kRows, kRows, kMost_bytes);
        CHECK(memory.free_bytes() > before);
        CHECK(memory.free_bytes() - before <= kMost_bytes);
        before = memory.free_bytes();
    }
    CHECK(memory.free_bytes() == kAll);
    CHECK(calls >= static_cast<int>(kAll / kMost_bytes));
    memory.reserve(kRows, kRows, kMost_bytes);
    CHECK(memory.free_bytes() == kAll);
    std::set<std::int64_t*> rows;
    for (std::size_t i = 0; i < kRows; ++i) {
        std::int64_t* const row = memory.take_sums();
        CHECK(row[kSums - 1] == 0);
        rows.insert(row);
    }
    CHECK(rows.size() == kRows);
}
