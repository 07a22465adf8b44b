#if defined(__APPLE__)
#include <pthread/qos.h>
#else
#include <pthread.h>
#include <sched.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>
#endif

#include <algorithm>
#include <cstdint>

#include "aula/audio/realtime.h"

namespace aula {

#if defined(__APPLE__)

// The threads of CoreAudio have the priority, others cannot take it.
bool take_realtime_priority() noexcept { return false; }

void lower_priority(int) noexcept { pthread_set_qos_class_self_np(QOS_CLASS_UTILITY, 0); }

// Threads do not inherit it.
void leave_realtime() noexcept {}

RealtimePriority::RealtimePriority() noexcept = default;
RealtimePriority::~RealtimePriority() = default;

#else

bool take_realtime_priority() noexcept {
    // Above JACK's threads (10 by default, its clients 5).
    constexpr int kPriority = 60;
    int policy = SCHED_OTHER;
    sched_param parameters{};
    if (pthread_getschedparam(pthread_self(), &policy, &parameters) == 0 &&
        (policy == SCHED_FIFO || policy == SCHED_RR)) {
        return true;
    }
    parameters.sched_priority = kPriority;
    return pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters) == 0;
}

// A running thread finishes its slice before a woken thread preempts it. Linux from 6.12 on takes
// the slice length from sched_setattr(2); earlier versions ignore it.
void lower_priority(int nice) noexcept {
    constexpr std::uint64_t kSlice_ns = 100'000;
    const int policy = sched_getscheduler(0);
    if (policy != SCHED_OTHER && policy != SCHED_BATCH) return;
    nice = std::max(nice, getpriority(PRIO_PROCESS, 0));
    // glibc has sched_setattr() from 2.41 on only.
    struct {
        std::uint32_t size;
        std::uint32_t policy;
        std::uint64_t flags = 0;
        std::int32_t nice;
        std::uint32_t priority = 0;
        std::uint64_t runtime_ns = kSlice_ns;
        std::uint64_t deadline_ns = 0;
        std::uint64_t period_ns = 0;
    } attributes{
        .size = sizeof(attributes), .policy = static_cast<std::uint32_t>(policy), .nice = nice};
    if (syscall(SYS_sched_setattr, 0, &attributes, 0U) != 0) setpriority(PRIO_PROCESS, 0, nice);
}

void leave_realtime() noexcept {
    int policy = SCHED_OTHER;
    sched_param parameters{};
    if (pthread_getschedparam(pthread_self(), &policy, &parameters) != 0) return;
    if (policy == SCHED_OTHER || policy == SCHED_BATCH || policy == SCHED_IDLE) return;
    parameters.sched_priority = 0;
    pthread_setschedparam(pthread_self(), SCHED_OTHER, &parameters);
}

RealtimePriority::RealtimePriority() noexcept {
    sched_param before{};
    pthread_getschedparam(pthread_self(), &policy_, &before);
    priority_ = before.sched_priority;
    take_realtime_priority();
}

RealtimePriority::~RealtimePriority() {
    sched_param before{};
    before.sched_priority = priority_;
    pthread_setschedparam(pthread_self(), policy_, &before);
}

#endif

}  // namespace aula
