#pragma once

// Marks a function called by the audio thread: no allocation, lock, log or system call. Compilers
// that know the attribute check the whole call tree.
#if defined(__clang__) && __has_cpp_attribute(clang::nonblocking)
#define AULA_NONBLOCKING [[clang::nonblocking]]
#else
#define AULA_NONBLOCKING
#endif

namespace aula {

/// Requests real-time priority (SCHED_FIFO) for this thread unless it already has it. Returns
/// whether it has it. [audio thread, first call]
bool take_realtime_priority() noexcept;

/// Raises the nice value (nice(2)) of this thread to at least `nice` and shortens its time slices,
/// so that a sound server of the same session is scheduled sooner. Threads started later inherit
/// both. Does nothing if the thread has real-time or idle priority. Cannot be reverted without
/// privileges.
void give_way(int nice) noexcept;

/// Gives up real-time priority that this thread has inherited. A thread starts with the scheduling
/// of the thread that starts it: call this first in a thread that computes.
void leave_realtime() noexcept;

/// Nice value of the threads that compute propagation frames.
inline constexpr int kNiceOfFrames = 10;

/// Gives this thread real-time priority while the object exists, unless the system refuses it.
/// Threads started meanwhile inherit and keep it.
class RealtimePriority {
 public:
    RealtimePriority() noexcept;
    ~RealtimePriority();
    RealtimePriority(const RealtimePriority&) = delete;
    RealtimePriority& operator=(const RealtimePriority&) = delete;

 private:
    int policy_ = 0;
    int priority_ = 0;
};

/// Flushes denormal numbers to zero on this thread while the object exists; decayed signals would
/// otherwise cost many times more. Does nothing without SSE. [audio thread]
class FlushDenormals {
 public:
    FlushDenormals() noexcept;
    ~FlushDenormals();
    FlushDenormals(const FlushDenormals&) = delete;
    FlushDenormals& operator=(const FlushDenormals&) = delete;

 private:
    unsigned saved_;
};

}  // namespace aula
