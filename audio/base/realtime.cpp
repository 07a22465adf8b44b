#include "aula/audio/realtime.h"

#include <pthread.h>
#include <sched.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>

#if defined(__SSE__)
#include <xmmintrin.h>
#endif

namespace aula {

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

namespace {

// The register that says how floating-point numbers are computed, and its bits that flush results
// and operands.
#if defined(__SSE__)
constexpr unsigned kFlush = 0x8000 | 0x0040;  // flush to zero, denormals are zero
unsigned floating_point_control() { return _mm_getcsr(); }
void set_floating_point_control(unsigned value) { _mm_setcsr(value); }
#elif defined(__aarch64__)
constexpr unsigned kFlush = 1U << 24;  // FZ of FPCR: both
unsigned floating_point_control() {
    std::uint64_t value = 0;
    asm volatile("mrs %0, fpcr" : "=r"(value));
    return static_cast<unsigned>(value);  // the upper half is reserved
}
void set_floating_point_control(unsigned value) {
    asm volatile("msr fpcr, %0" : : "r"(std::uint64_t{value}));
}
#else
constexpr unsigned kFlush = 0;
unsigned floating_point_control() { return 0; }
void set_floating_point_control(unsigned) {}
#endif

}  // namespace

FlushDenormals::FlushDenormals() noexcept : saved_(floating_point_control()) {
    set_floating_point_control(saved_ | kFlush);
}
FlushDenormals::~FlushDenormals() { set_floating_point_control(saved_); }

}  // namespace aula
