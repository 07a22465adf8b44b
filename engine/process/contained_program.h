#pragma once

#include <sys/prctl.h>
#include <sys/resource.h>

#include <csignal>
#include <cstdio>
#include <vector>

namespace aula {

// For the programs that a ContainedProcess runs.

/// Limits memory and time of the process. They allow several times the memory of the largest valid
/// file, and its time on a slow machine.
inline void limit_resources() {
    constexpr rlim_t kMemory_bytes = rlim_t{1} << 30;
    constexpr rlim_t kTime_s = 5;
    const auto limit = [](__rlimit_resource resource, rlim_t max) {
        const rlimit limits{max, max};
        setrlimit(resource, &limits);
    };
    limit(RLIMIT_AS, kMemory_bytes);
    limit(RLIMIT_CPU, kTime_s);
    limit(RLIMIT_CORE, 0);
    limit(RLIMIT_FSIZE, 0);
    prctl(PR_SET_PDEATHSIG, SIGKILL);
}

/// Writes bytes, a value or all elements of a vector to the answer.
inline bool write_bytes(const void* bytes, std::size_t size) {
    return std::fwrite(bytes, 1, size, stdout) == size;
}
template <typename T>
bool write(const T& value) {
    return write_bytes(&value, sizeof(value));
}
template <typename T>
bool write(const std::vector<T>& values) {
    return write_bytes(values.data(), values.size() * sizeof(T));
}

}  // namespace aula
