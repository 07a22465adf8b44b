#include "apps/bench/convolution/core_share.h"

#include <chrono>

namespace aula::bench {

#if defined(__x86_64__) && defined(__GNUC__)

std::optional<double> additions_per_cycle() {
    constexpr int kRounds = 10000;
    using Clock = std::chrono::steady_clock;
    const auto began = Clock::now();
    for (int i = 0; i < kRounds; ++i) {
        // One after the other: a cycle each, whoever else uses the core. Of registers, as some
        // processors add numbers that stand in the instruction before it comes to the units.
        asm volatile(
            ".rept 32;"
            "add %%rcx, %%rax;"
            ".endr" ::
                : "rax", "cc");
    }
    const auto between = Clock::now();
    for (int i = 0; i < kRounds; ++i) {
        // All at once.
        asm volatile(
            ".rept 4;"
            "add %%rcx, %%rax; add %%rcx, %%rdx; add %%rcx, %%rsi; add %%rcx, %%rdi;"
            "add %%rcx, %%r8; add %%rcx, %%r9; add %%rcx, %%r10; add %%rcx, %%r11;"
            ".endr" ::
                : "rax", "rdx", "rsi", "rdi", "r8", "r9", "r10", "r11", "cc");
    }
    const auto ended = Clock::now();
    const std::chrono::duration<double> in_turn = between - began;
    const std::chrono::duration<double> at_once = ended - between;
    return in_turn / at_once;
}

#else

std::optional<double> additions_per_cycle() { return std::nullopt; }

#endif

}  // namespace aula::bench
