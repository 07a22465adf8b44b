#include "audio/base/aligned.h"

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <complex>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <limits>
#include <new>
#include <vector>

using namespace aula;

namespace {

bool aligned_to(const void* p, std::size_t bytes) {
    return reinterpret_cast<std::uintptr_t>(p) % bytes == 0;
}

}  // namespace

TEST_CASE("Memory of any size is aligned to a cache line and can be written to its end") {
    // Around 1 MiB, from where on whole huge pages of 2 MiB are used.
    constexpr std::size_t kLarge = std::size_t{1} << 20;
    for (const std::size_t bytes : {std::size_t{1}, std::size_t{63}, std::size_t{64},
                                    std::size_t{4097}, kLarge - 1, kLarge, 2 * kLarge + 1}) {
        CAPTURE(bytes);
        auto* const p = static_cast<unsigned char*>(allocate_aligned(bytes));
        CHECK(aligned_to(p, kAlignment_bytes));
        if (bytes >= kLarge) CHECK(aligned_to(p, 2 * kLarge));
        p[0] = 1;
        p[bytes - 1] = 2;
        CHECK(p[bytes - 1] == 2);
        free_aligned(p, bytes);
    }
}

TEST_CASE("Large memory is not backed by small pages before its first use") {
    constexpr std::size_t kBytes = std::size_t{4} << 20;
    // Freed memory that the heap keeps is backed by small pages.
    std::vector<void*> freed(16);
    for (void*& block : freed) {
        block = std::malloc(kBytes);
        REQUIRE(block != nullptr);
        std::memset(block, 1, kBytes);
    }
    for (void* block : freed) std::free(block);

    std::vector<void*> blocks(8);
    for (void*& block : blocks) {
        block = allocate_aligned(kBytes);
        std::vector<unsigned char> resident(kBytes / static_cast<std::size_t>(getpagesize()));
        REQUIRE(mincore(block, kBytes, resident.data()) == 0);
        CHECK(std::none_of(resident.begin(), resident.end(), [](auto x) { return x & 1U; }));
    }
    for (void* block : blocks) free_aligned(block, kBytes);
}

TEST_CASE("Vectors of aligned memory start with zeros and keep their alignment when they grow") {
    AlignedVector<float> samples(17);
    AlignedVector<std::complex<float>> bins(3);
    for (const float x : samples) CHECK(x == 0);
    for (const auto& bin : bins) CHECK(bin == std::complex<float>());
    CHECK(aligned_to(bins.data(), kAlignment_bytes));
    for (int n = 0; n < 2000; ++n) {
        samples.push_back(static_cast<float>(n));
        REQUIRE(aligned_to(samples.data(), kAlignment_bytes));
    }
    CHECK(samples[17 + 1999] == 1999);
    const AlignedVector<float> moved = std::move(samples);
    CHECK(moved.size() == 2017);
}

// The address sanitizer has memory of its own, and ends the process at a request of all of it.
#ifndef __SANITIZE_ADDRESS__
TEST_CASE("Memory slightly larger than a huge page is not rounded up to the next one") {
    const auto resident_bytes = [] {
        std::ifstream file("/proc/self/statm");
        std::size_t pages = 0;
        file >> pages >> pages;
        return pages * static_cast<std::size_t>(getpagesize());
    };
    for (const double huge_pages : {0.55, 1.1, 2.1}) {
        CAPTURE(huge_pages);
        const auto bytes = static_cast<std::size_t>(huge_pages * (std::size_t{2} << 20));
        std::vector<void*> blocks(16);
        const std::size_t before = resident_bytes();
        for (void*& block : blocks) {
            block = allocate_aligned(bytes);
            std::memset(block, 1, bytes);
        }
        const std::size_t after = resident_bytes();
        for (void* block : blocks) free_aligned(block, bytes);
        CHECK(static_cast<double>(after - before) < 1.2 * static_cast<double>(16 * bytes));
    }
}

TEST_CASE("More memory than there is throws bad_alloc") {
    const std::size_t all = std::numeric_limits<std::size_t>::max() / 4;
    CHECK_THROWS_AS(allocate_aligned(all), std::bad_alloc);
}
#endif
