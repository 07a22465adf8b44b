#pragma once

#include <ctime>

namespace aula::test {

/// The processor's time that all threads of the process take while `work` runs, in seconds. On
/// Windows, whose std::clock() is another, the time that passes.
template <typename Work>
double cpu_time_s(const Work& work) {
    const std::clock_t start = std::clock();
    work();
    return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
}

}  // namespace aula::test
