#include "audio/realtime.h"

#include <pthread.h>
#include <sched.h>

#if defined(__SSE__)
#include <xmmintrin.h>
#endif

namespace aula {

bool take_realtime_priority() noexcept {
    // Below JACK's own threads (10 by default, its clients 5 below that) nothing is gained.
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

#if defined(__SSE__)
namespace {
constexpr unsigned kFlushToZero = 0x8000;
constexpr unsigned kDenormalsAreZero = 0x0040;
}  // namespace

FlushDenormals::FlushDenormals() noexcept : saved_(_mm_getcsr()) {
    _mm_setcsr(saved_ | kFlushToZero | kDenormalsAreZero);
}
FlushDenormals::~FlushDenormals() { _mm_setcsr(saved_); }
#else
FlushDenormals::FlushDenormals() noexcept : saved_(0) {}
FlushDenormals::~FlushDenormals() = default;
#endif

}  // namespace aula
