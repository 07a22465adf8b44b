#include "apps/bench/base/machine.h"

#include <aula_revision.h>
#include <algorithm>
#include <fstream>
#include <thread>

#include "process/instruction_set.h"

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
    switch (kBestInstructionSet) {
        case InstructionSet::kAvx512:
            return "AVX-512";
        case InstructionSet::kAvx2:
            return "AVX2";
        case InstructionSet::kPortable:
            return "the compiler's default";
    }
    return "";
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
