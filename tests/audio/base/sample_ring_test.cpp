#include "audio/base/sample_ring.h"

#include <array>
#include <catch2/catch.hpp>
#include <thread>

using aula::SampleRing;

TEST_CASE("A ring takes all samples of a call or none") {
    SampleRing ring(8);
    const std::array<float, 5> five{1, 2, 3, 4, 5};
    CHECK(ring.write(five));
    CHECK_FALSE(ring.write(five));
    std::array<float, 16> out{};
    CHECK(ring.read(out) == 5);
    CHECK(out[4] == 5);
    CHECK(ring.read(out) == 0);
    CHECK(ring.write(five));  // across the end of the memory
    CHECK(ring.read(std::span(out).first(3)) == 3);
    CHECK(ring.read(out) == 2);
    CHECK(out[1] == 5);
}

TEST_CASE("Between two threads every sample is read once, in order") {
    SampleRing ring(256);
    constexpr int kSamples = 300'000;
    std::thread writer([&] {
        for (int next = 0; next < kSamples;) {
            std::array<float, 7> block{};
            for (std::size_t i = 0; i < block.size(); ++i)
                block[i] = static_cast<float>(next + static_cast<int>(i));
            if (ring.write(block)) next += static_cast<int>(block.size());
        }
    });
    int wrong = 0;
    int next = 0;
    std::array<float, 100> out{};
    while (next < kSamples) {
        const std::size_t count = ring.read(out);
        for (std::size_t i = 0; i < count; ++i, ++next) wrong += out[i] != static_cast<float>(next);
    }
    writer.join();
    CHECK(wrong == 0);
}

TEST_CASE("A ring holds its whole capacity and skips at most the samples that it holds") {
    SampleRing ring(8);
    const std::array<float, 8> eight{1, 2, 3, 4, 5, 6, 7, 8};
    CHECK(ring.write(eight));
    ring.skip(3);
    CHECK(ring.size() == 5);
    ring.skip(100);
    CHECK(ring.size() == 0);
    CHECK(ring.write(eight));
    std::array<float, 16> out{};
    CHECK(ring.read(out) == 8);
    CHECK(out[0] == 1);
    CHECK(out[7] == 8);
}
