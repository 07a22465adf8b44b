#include <windows.h>

#include <algorithm>

#include "aula/audio/realtime.h"

namespace aula {

namespace {

constexpr int kRealtime = THREAD_PRIORITY_TIME_CRITICAL;

}  // namespace

bool take_realtime_priority() noexcept {
    return SetThreadPriority(GetCurrentThread(), kRealtime) != 0;
}

void lower_priority(int nice) noexcept {
    const int priority = GetThreadPriority(GetCurrentThread());
    if (priority == kRealtime || priority == THREAD_PRIORITY_ERROR_RETURN || nice <= 0) return;
    SetThreadPriority(GetCurrentThread(), std::min(priority, THREAD_PRIORITY_BELOW_NORMAL));
}

// Threads do not inherit priorities there.
void leave_realtime() noexcept {}

RealtimePriority::RealtimePriority() noexcept : priority_(GetThreadPriority(GetCurrentThread())) {
    take_realtime_priority();
}

RealtimePriority::~RealtimePriority() { SetThreadPriority(GetCurrentThread(), priority_); }

}  // namespace aula
