#pragma once

// Marks a function that the audio thread calls: no allocation, no lock, no log, no system call.
// Where the compiler knows the attribute it checks the whole call tree.
#if defined(__clang__) && __has_cpp_attribute(clang::nonblocking)
#define AULA_NONBLOCKING [[clang::nonblocking]]
#else
#define AULA_NONBLOCKING
#endif

namespace aula {

/// Asks for real-time priority unless this thread has it; false where the system refuses it.
/// [audio thread, first call]
bool take_realtime_priority() noexcept;

/// Makes this thread, and those that it begins, at least so nice (nice(2)), and has them run in
/// short slices, so that a sound server of the same session waits less for them. Does nothing to
/// threads that are real-time or idle. For good: the way back needs privileges.
void give_way(int nice) noexcept;

/// How nice threads are that compute what will be heard.
inline constexpr int kNiceOfFrames = 10;

/// Real-time priority for this thread while alive, unless the system refuses it. Threads that it
/// begins meanwhile have it too, and keep it.
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

/// Flushes denormal numbers to zero on this thread while alive; a decayed input otherwise costs
/// many times more. Does nothing where there is no SSE. [audio thread]
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
