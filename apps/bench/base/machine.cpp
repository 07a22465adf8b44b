#include "apps/bench/base/machine.h"

#include <aula_revision.h>
#include <algorithm>
#include <fstream>
#include <thread>

namespace aula::bench {

namespace {

std::string processor_model() {
    std::ifstream information("/proc/cpuinfo");
    for (std::string line; std::getline(information, line);) {
        if (line.starts_with("model name")) {
            return line.substr(std::min(line.size(), line.find(':') + 2));
        }
    }
    return "unknown processor";
}

std::string instruction_set() {
#if defined(__x86_64__) && defined(__GNUC__)
    if (__builtin_cpu_supports("avx512f")) return "AVX-512";
    if (__builtin_cpu_supports("avx2")) return "AVX2";
    return "SSE2";
#else
    return "the compiler's default";
#endif
}

}  // namespace

Machine machine() {
    return {processor_model(), std::thread::hardware_concurrency(), instruction_set(),
            AULA_BENCH_BUILD, AULA_REVISION};
}

std::string machine_line() {
    const Machine m = machine();
    return m.processor + ", " + std::to_string(m.processors) + " processors, " + m.instruction_set +
           ", " + m.compiler + ", commit " + m.revision;
}

}  // namespace aula::bench
