#pragma once

#include <cstdint>

namespace aula::test {

/// What a thread did that an audio thread must not do.
struct RealtimeViolations {
    std::uint64_t allocations = 0;
    std::uint64_t frees = 0;
    std::uint64_t locks = 0;
    std::uint64_t writes = 0;
    std::uint64_t page_faults = 0;
    std::uint64_t voluntary_switches = 0;  ///< to another thread, by waiting

    /// Of calls: what they do besides is counted only once.
    std::uint64_t total() const { return allocations + frees + locks + writes; }

    RealtimeViolations& operator+=(const RealtimeViolations& other);
};

/// Counts, on the thread that made it and while it is alive, every call to malloc and its kin,
/// free, pthread_mutex_lock and write in this program: linking realtime_trap.cpp puts them in place
/// of the C library's. What the system counts of the thread, faults and switches, is counted from
/// one trap to the end of it. Traps do not nest.
class RealtimeTrap {
 public:
    RealtimeTrap();
    ~RealtimeTrap();
    RealtimeTrap(const RealtimeTrap&) = delete;
    RealtimeTrap& operator=(const RealtimeTrap&) = delete;

    RealtimeViolations violations() const;

    /// False under sanitizers, which have these functions to themselves: nothing is counted.
    static bool available();
};

}  // namespace aula::test
