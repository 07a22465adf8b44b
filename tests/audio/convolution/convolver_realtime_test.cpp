#include <sys/mman.h>
#include <time.h>

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <deque>
#include <vector>

#include "aula/audio/convolver.h"
#include "tests/audio/convolution/convolution.h"
#include "tests/support/realtime_trap.h"

using namespace aula;
using namespace aula::test;

TEST_CASE("The trap detects a page fault and a switch to another thread") {
    if (!RealtimeTrap::available()) {
        WARN("skipped: sanitizers own these functions");
        return;
    }
    constexpr std::size_t kPage_bytes = 4096;
    void* const page =
        mmap(nullptr, kPage_bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    REQUIRE(page != MAP_FAILED);
    RealtimeViolations faulted;
    RealtimeViolations switched;
    {
        const RealtimeTrap trap;
        *static_cast<volatile char*>(page) = 1;
        faulted = trap.violations();
    }
    {
        const RealtimeTrap trap;
        // The shortest possible wait causes the switch.
        const timespec moment{0, 1};
        nanosleep(&moment, nullptr);
        switched = trap.violations();
    }
    munmap(page, kPage_bytes);
    CHECK(faulted.page_faults == 1);
    CHECK(switched.voluntary_switches == 1);
}

TEST_CASE("20000 blocks of convolution make no forbidden call, fault or wait, and decay to zero") {
    if (!RealtimeTrap::available()) {
        WARN("skipped: sanitizers own these functions");
        return;
    }
    const bool half = GENERATE(false, true);
    constexpr std::size_t kBlock = 128;
    constexpr std::size_t kBlocks = 20000;
    const ConvolutionShape shape{2, 2, kBlock, 20000, half};
    REQUIRE(partition_levels(shape).size() == 3);
    const FlushDenormals flush;
    FilterTransform transform(shape);
    std::vector<ConvolutionFilter> filters;
    for (unsigned k = 0; k < 5; ++k) {
        filters.emplace_back(shape);
        fill(transform, random_responses(shape, 20000, 10 * k), filters.back());
    }
    const Signals noise = random_signals(2, kBlock, 1);
    const Signal silence(kBlock);
    Signals outputs(2, Signal(kBlock));
    const std::array<float*, 2> out{outputs[0].data(), outputs[1].data()};
    const std::array<const float*, 2> loud{noise[0].data(), noise[1].data()};
    const std::array<const float*, 2> silent{silence.data(), silence.data()};

    // The kernel may migrate pages at any time, which causes a fault and a wait. A fault or wait
    // that the convolver causes occurs in every run, each with newly allocated memory.
    constexpr std::size_t kMaxRuns = 3;
    std::deque<Convolver> convolvers;
    RealtimeViolations violations;
    while (convolvers.size() < kMaxRuns) {
        Convolver& convolver = convolvers.emplace_back(shape, 512);
        violations = {};
        float loudest = 0;
        std::size_t exchanges = 0;
        for (std::size_t block = 0; block < kBlocks; ++block) {
            // Every other 500 blocks are silent, which is longer than the response.
            const bool sounding = block % 1000 < 500;
            const std::size_t samples = block % 10 == 9 ? 1 + block % kBlock : kBlock;
            {
                const RealtimeTrap trap;
                if (block % 12 == 0) convolver.exchange(&filters[exchanges++ % filters.size()]);
                convolver.process(sounding ? loud : silent, out, samples);
                violations += trap.violations();
            }
            for (const Signal& output : outputs) {
                for (const float x : output) loudest = std::max(loudest, std::abs(x));
            }
            if (block % 1000 == 999) {
                // Exact: zero, not a denormal number.
                CHECK(std::all_of(outputs[0].begin(),
                                  outputs[0].begin() + static_cast<std::ptrdiff_t>(samples),
                                  [](float x) { return x == 0; }));
            }
        }
        CHECK(violations.total() == 0);
        CHECK(exchanges > 1600);
        CHECK(loudest > 0.1F);
        if (violations.page_faults == 0 && violations.voluntary_switches == 0) break;
    }
    CHECK(violations.page_faults == 0);
    CHECK(violations.voluntary_switches == 0);
}
