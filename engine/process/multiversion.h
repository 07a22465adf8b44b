#pragma once

#include "process/instruction_set.h"

/// Marks a hot function that is called by best_version() only.
#define AULA_MULTIVERSION [[gnu::always_inline]] inline

namespace aula {

/// A function marked AULA_MULTIVERSION, compiled for each instruction set: it is inlined into each
/// version. The loaders of MinGW, musl and macOS could not select one (ifunc), as that of glibc.
template <auto kFunction>
struct Versions;

template <typename R, typename... A, bool kNoexcept, R (*kFunction)(A...) noexcept(kNoexcept)>
struct Versions<kFunction> {
    static R portable(A... arguments) noexcept(kNoexcept) { return kFunction(arguments...); }
#if defined(__x86_64__)
    [[gnu::target("avx2,bmi,bmi2,f16c,fma,popcnt")]] static R avx2(A... arguments) noexcept(
        kNoexcept) {
        return kFunction(arguments...);
    }
    [[gnu::target(
        "avx2,bmi,bmi2,f16c,fma,popcnt,avx512bw,avx512cd,avx512dq,avx512f,avx512vl")]] static R
    avx512(A... arguments) noexcept(kNoexcept) {
        return kFunction(arguments...);
    }
#endif
    static R call(InstructionSet set, A... arguments) noexcept(kNoexcept) {
#if defined(__x86_64__)
        if (set == InstructionSet::kAvx512) return avx512(arguments...);
        if (set == InstructionSet::kAvx2) return avx2(arguments...);
#endif
        static_cast<void>(set);
        return portable(arguments...);
    }
};

/// Calls the version of a function for the processor's instruction set.
template <auto kFunction, typename... A>
auto best_version(A&&... arguments) noexcept(
    noexcept(Versions<kFunction>::portable(static_cast<A&&>(arguments)...))) {
    return Versions<kFunction>::call(kBestInstructionSet, static_cast<A&&>(arguments)...);
}

}  // namespace aula
