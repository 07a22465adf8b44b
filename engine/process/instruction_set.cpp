#include "process/instruction_set.h"

#if defined(__x86_64__)
#include <cpuid.h>
#endif

namespace aula {

namespace {

#if defined(__x86_64__)
/// Clang 14's __builtin_cpu_supports does not know "f16c".
bool has_f16c() {
    unsigned a = 0;
    unsigned b = 0;
    unsigned c = 0;
    unsigned d = 0;
    return __get_cpuid(1, &a, &b, &c, &d) != 0 && (c & bit_F16C) != 0;
}
#endif

InstructionSet best_instruction_set() {
#if defined(__x86_64__)
    __builtin_cpu_init();
    const bool avx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("bmi") &&
                      __builtin_cpu_supports("bmi2") && __builtin_cpu_supports("fma") &&
                      __builtin_cpu_supports("popcnt") && has_f16c();
    const bool avx512 = __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512cd") &&
                        __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512f") &&
                        __builtin_cpu_supports("avx512vl");
    if (avx2) return avx512 ? InstructionSet::kAvx512 : InstructionSet::kAvx2;
#endif
    return InstructionSet::kPortable;
}

}  // namespace

const InstructionSet kBestInstructionSet = best_instruction_set();

}  // namespace aula
