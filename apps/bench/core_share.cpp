#include "apps/bench/core_share.h"

#include <chrono>

namespace aula::bench {

#if defined(__x86_64__) && defined(__GNUC__)

std::optional<double> additions_per_cycle() {
    constexpr int kRounds = 20000;
    using Clock = std::chrono::steady_clock;
    const auto began = Clock::now();
    for (int i = 0; i < kRounds; ++i) {
        // One after the other: a cycle each, whoever else uses the core.
        asm volatile(
            "add $1, %%rax; add $1, %%rax; add $1, %%rax; add $1, %%rax;"
            "add $1, %%rax; add $1, %%rax; add $1, %%rax; add $1, %%rax;"
            "add $1, %%rax; add $1, %%rax; add $1, %%rax; add $1, %%rax;"
            "add $1, %%rax; add $1, %%rax; add $1, %%rax; add $1, %%rax;" ::
                : "rax", "cc");
    }
    const auto between = Clock::now();
    for (int i = 0; i < kRounds; ++i) {
        // All at once.
        asm volatile(
            "add $1, %%rax; add $1, %%rcx; add $1, %%rdx; add $1, %%rsi;"
            "add $1, %%rdi; add $1, %%r8; add $1, %%r9; add $1, %%r10;"
            "add $1, %%rax; add $1, %%rcx; add $1, %%rdx; add $1, %%rsi;"
            "add $1, %%rdi; add $1, %%r8; add $1, %%r9; add $1, %%r10;" ::
                : "rax", "rcx", "rdx", "rsi", "rdi", "r8", "r9", "r10", "cc");
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
