#pragma once

#include <cstdint>

namespace aula::test {

/// Counts of operations that an audio thread must not perform.
struct RealtimeViolations {
    std::uint64_t allocations = 0;
    std::uint64_t frees = 0;
    std::uint64_t locks = 0;
    std::uint64_t writes = 0;
    std::uint64_t page_faults = 0;
    std::uint64_t voluntary_switches = 0;  ///< context switches by waiting

    /// Number of calls, without the system's counts.
    std::uint64_t total() const { return allocations + frees + locks + writes; }

    RealtimeViolations& operator+=(const RealtimeViolations& other);
};

/// Counts calls of the malloc family, free, pthread_mutex_lock and write on its thread while alive.
/// realtime_trap.cpp replaces these functions of the C library. Page faults and context switches
/// are the system's counts for the thread since the trap's construction. Traps do not nest.
class RealtimeTrap {
 public:
    RealtimeTrap();
    ~RealtimeTrap();
    RealtimeTrap(const RealtimeTrap&) = delete;
    RealtimeTrap& operator=(const RealtimeTrap&) = delete;

    RealtimeViolations violations() const;

    /// False under sanitizers, which replace the same functions: nothing is counted.
    static bool available();
};

}  // namespace aula::test
