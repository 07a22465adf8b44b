#pragma once

/// Marks a function that the audio thread calls: no allocation, lock or log, and no system call
/// that may wait. Compilers that know the attribute check the whole call tree. Clang 19 knows it
/// and checks no call.
#if defined(__clang__) && __clang_major__ >= 20
#define AULA_NONBLOCKING [[clang::nonblocking]]
#else
#define AULA_NONBLOCKING
#endif

namespace aula {

/// Requests real-time priority (SCHED_FIFO; on Windows THREAD_PRIORITY_TIME_CRITICAL) for this
/// thread unless it already has it. Returns true if the thread then has it; Linux refuses it
/// without the privilege, and macOS always. Call it once at the start of an audio thread.
bool take_realtime_priority() noexcept;

/// Raises the nice value (nice(2)) of this thread to at least `nice`, 0 to 19, and shortens its
/// time slices, so that a sound server of the same session is scheduled sooner. Threads that it
/// starts later inherit both. Does nothing if the thread has real-time or idle priority. Cannot be
/// reverted without privileges. On Windows the thread has THREAD_PRIORITY_BELOW_NORMAL, on macOS
/// QOS_CLASS_UTILITY, and the threads that it starts do not.
void lower_priority(int nice) noexcept;

/// Gives up real-time priority that this thread has inherited: a thread starts with the scheduling
/// of the thread that starts it. Call it at the start of a thread that computes.
void leave_realtime() noexcept;

/// Nice value of the threads that compute propagation frames.
inline constexpr int kPropagationNice = 10;

/// Gives this thread real-time priority while the object exists, unless the system refuses it.
/// Threads started meanwhile inherit and keep it.
class RealtimePriority {
 public:
    /// Calls take_realtime_priority().
    RealtimePriority() noexcept;
    /// Restores the priority that the thread had before; must run on the same thread.
    ~RealtimePriority();
    RealtimePriority(const RealtimePriority&) = delete;
    RealtimePriority& operator=(const RealtimePriority&) = delete;

 private:
    int policy_ = 0;
    int priority_ = 0;
};

/// Flushes denormal numbers to zero on this thread while the object exists; decayed signals would
/// otherwise cost many times more. On x86 with SSE and on AArch64. [audio thread]
class FlushDenormals {
 public:
    /// Flushes denormal results and operands on this thread.
    FlushDenormals() noexcept AULA_NONBLOCKING;
    /// Restores the modes before; must run on the same thread.
    ~FlushDenormals() noexcept AULA_NONBLOCKING;
    FlushDenormals(const FlushDenormals&) = delete;
    FlushDenormals& operator=(const FlushDenormals&) = delete;

 private:
    unsigned saved_;
};

}  // namespace aula
