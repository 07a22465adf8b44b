#include "engine/cache/row_pool.h"

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdint>
#include <set>
#include <utility>
#include <vector>

#include "aula/engine/bands.h"

namespace row_pool_test {

using namespace aula;

namespace {

constexpr std::size_t kBins = 100;
constexpr std::size_t kSums = kBins * kBandCount;
constexpr std::size_t kDirections = kBins * RowPool::kMoments;

/// Whether the kernel has provided all pages of a row.
bool is_mapped(const float* row, std::size_t size) {
    const auto page = static_cast<std::uintptr_t>(sysconf(_SC_PAGESIZE));
    const auto begin = reinterpret_cast<std::uintptr_t>(row) / page * page;
    const auto end = reinterpret_cast<std::uintptr_t>(row + size);
    std::vector<unsigned char> pages((end - begin + page - 1) / page);
    REQUIRE(mincore(reinterpret_cast<void*>(begin), end - begin, pages.data()) == 0);
    return std::all_of(pages.begin(), pages.end(), [](unsigned char p) { return (p & 1U) != 0; });
}

}  // namespace

TEST_CASE("memory of rows serves a row again that was given back") {
    RowPool memory(kBins);
    float* const sums = memory.take_sums();
    float* const directions = memory.take_directions();
    CHECK(std::all_of(sums, sums + kSums, [](float x) { return x == 0; }));
    CHECK(memory.free_bytes() == 0);
    memory.give_back(sums, nullptr, 0, 0);
    CHECK(memory.free_bytes() == kSums * sizeof(float));
    memory.give_back(nullptr, directions, 0, 0);
    CHECK(memory.free_bytes() == (kSums + kDirections) * sizeof(float));
    CHECK(memory.take_directions() == directions);
    CHECK(memory.take_sums() == sums);
    CHECK(memory.take_sums() != sums);
    CHECK(memory.free_bytes() == 0);
}

TEST_CASE("rows that were given back with energy are zero when they are taken again") {
    constexpr std::size_t kFirst = 7;
    constexpr std::size_t kEnd = 60;
    constexpr std::size_t kRows = 40;
    RowPool memory(kBins);
    std::set<float*> given;
    const auto take = [&] {
        std::vector<std::pair<float*, float*>> rows;
        for (std::size_t i = 0; i < kRows; ++i) {
            rows.emplace_back(memory.take_sums(), memory.take_directions());
            const auto [sums, directions] = rows.back();
            CHECK(std::all_of(sums, sums + kSums, [](float x) { return x == 0; }));
            CHECK(
                std::all_of(directions, directions + kDirections, [](float x) { return x == 0; }));
        }
        return rows;
    };
    const auto give_back = [&](const auto& rows) {
        for (const auto& [sums, directions] : rows) {
            std::fill(sums + kFirst * kBandCount, sums + kEnd * kBandCount, 5);
            std::fill(directions + kFirst * RowPool::kMoments,
                      directions + kEnd * RowPool::kMoments, -5);
            memory.give_back(sums, directions, kFirst, kEnd);
            given.insert(sums);
        }
        CHECK(memory.free_bytes() == kRows * (kSums + kDirections) * sizeof(float));
    };
    const auto all_again = [&](const auto& rows) {
        return std::all_of(rows.begin(), rows.end(),
                           [&](const auto& row) { return given.count(row.first) > 0; });
    };
    // Cleared when they are taken.
    give_back(take());
    const auto again = take();
    CHECK(all_again(again));
    CHECK(memory.free_bytes() == 0);
    // Cleared by calls of reserve(), a quarter of the given bytes in each, which maps no more rows
    // meanwhile.
    give_back(again);
    const auto cleared = [&] {
        return std::count_if(again.begin(), again.end(),
                             [](const auto& row) { return row.first[kFirst * kBandCount] == 0; });
    };
    CHECK(cleared() == 0);
    for (int i = 1; i <= 10; ++i) {
        memory.reserve(kRows, kRows, 16 * kSums * sizeof(float));
        CHECK(cleared() == 4 * i);
        CHECK(memory.free_bytes() == kRows * (kSums + kDirections) * sizeof(float));
    }
    CHECK(all_again(take()));
}

TEST_CASE("rows are reserved up to a number, at most a given size in one call") {
    RowPool memory(kBins);
    constexpr std::size_t kMost_bytes = std::size_t{2} << 20;
    constexpr std::size_t kRows = 1000;
    constexpr std::size_t kAll = kRows * (kSums + kDirections) * sizeof(float);
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
    std::set<float*> rows;
    for (std::size_t i = 0; i < kRows; ++i) {
        float* const row = memory.take_sums();
        CHECK(row[kSums - 1] == 0);
        rows.insert(row);
    }
    CHECK(rows.size() == kRows);
}

TEST_CASE("all pages of reserved rows are mapped") {
    constexpr std::size_t kLongBins = 1000;  // 8 pages of 4 KiB in a row
    constexpr std::size_t kRows = 8;
    RowPool memory(kLongBins);
    memory.reserve(kRows, kRows, std::size_t{2} << 20);
    for (std::size_t i = 0; i < kRows; ++i) {
        CHECK(is_mapped(memory.take_sums(), kLongBins * kBandCount));
        CHECK(is_mapped(memory.take_directions(), kLongBins * RowPool::kMoments));
    }
}

}  // namespace row_pool_test
