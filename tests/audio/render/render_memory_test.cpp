#include "audio/render/render_memory.h"

#include <malloc.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cstdint>
#include <fstream>
#include <limits>

#include "tests/audio/player.h"

using namespace aula;
using namespace aula::test;

namespace {

/// The memory of the process.
double resident_bytes() {
    std::uint64_t mapped = 0;
    std::uint64_t pages = 0;
    std::ifstream("/proc/self/statm") >> mapped >> pages;
    return static_cast<double>(pages) * static_cast<double>(sysconf(_SC_PAGESIZE));
}

}  // namespace

TEST_CASE("The estimate of a renderer's memory is what its constructor takes") {
    const OutputFormat output = GENERATE(OutputFormat::mono, OutputFormat::toa);
    const int block = GENERATE(64, 1024);
    RendererConfig config = config_for(output, 64, 48000);
    config.block = block;
    malloc_trim(0);  // what is free on the heap
    const double before = resident_bytes();
    const Renderer renderer(config, nullptr);
    const double taken = resident_bytes() - before;
    const auto estimate = static_cast<double>(renderer_bytes(config, nullptr));
    CAPTURE(taken / 1e6, estimate / 1e6);
    // Rounding of large blocks to pages of 2 MB, and what does not grow with the sources: the sums
    // of 16 outputs.
    CHECK(taken == Approx(estimate).epsilon(0.15));
}

TEST_CASE("The estimate grows with sources and listeners, up to the largest number") {
    const RendererConfig one = config_for(OutputFormat::mono, 1, 4800);
    RendererConfig many = one;
    many.sources = 100;
    // The partition of a filter depends on the number of inputs.
    const auto bytes = static_cast<double>(renderer_bytes(one, nullptr));
    CHECK(static_cast<double>(renderer_bytes(many, nullptr)) == Approx(100 * bytes).epsilon(0.1));
    CHECK(renderer_bytes(one, nullptr, 64) == 64 * renderer_bytes(one, nullptr));
    many.sources = std::size_t{1} << 40;
    CHECK(renderer_bytes(many, nullptr, std::size_t{1} << 30) ==
          std::numeric_limits<std::uint64_t>::max());
}
