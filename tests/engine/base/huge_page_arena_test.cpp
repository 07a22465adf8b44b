#include "engine/base/huge_page_arena.h"

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <cstring>
#include <vector>

using aula::HugePageArena;

namespace {

constexpr std::size_t kMax = std::size_t{1} << 19;

bool is_zero(const float* row, std::size_t count) {
    return std::all_of(row, row + count, [](float x) { return x == 0; });
}

}  // namespace

TEST_CASE("rows of a huge-page arena are zero, aligned and apart, at any size") {
    HugePageArena arena;
    std::vector<std::pair<float*, std::size_t>> rows;
    for (const std::size_t count : {1U, 9U, 5000U, 40000U, 1U, 200000U, 524288U, 3U, 524288U}) {
        float* const row = arena.take(count);
        REQUIRE(reinterpret_cast<std::uintptr_t>(row) % 64 == 0);
        REQUIRE(is_zero(row, count));
        std::fill_n(row, count, static_cast<float>(rows.size() + 1));
        rows.emplace_back(row, count);
    }
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const auto [row, count] = rows[i];
        CHECK(std::count(row, row + count, static_cast<float>(i + 1)) ==
              static_cast<std::ptrdiff_t>(count));
    }
}

TEST_CASE("a huge page of rows is not backed by small pages before its first use") {
    // Freed memory that the heap keeps is backed by small pages.
    std::vector<void*> freed(16);
    for (void*& block : freed) {
        block = std::malloc(kMax * sizeof(float));
        REQUIRE(block != nullptr);
        std::memset(block, 1, kMax * sizeof(float));
    }
    for (void* block : freed) std::free(block);

    HugePageArena arena;
    const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
    for (int i = 0; i < 16; ++i) {
        float* const row = arena.take(kMax);
        REQUIRE(reinterpret_cast<std::uintptr_t>(row) % (kMax * sizeof(float)) == 0);
        std::vector<unsigned char> resident(kMax * sizeof(float) / page);
        REQUIRE(mincore(row, kMax * sizeof(float), resident.data()) == 0);
        CHECK(std::none_of(resident.begin(), resident.end(), [](auto x) { return x & 1U; }));
    }
}
