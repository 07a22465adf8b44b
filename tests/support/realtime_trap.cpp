#include "tests/support/realtime_trap.h"

#include <dlfcn.h>
#include <pthread.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>

namespace aula::test {

namespace {

thread_local bool trapped = false;
thread_local RealtimeViolations seen;
thread_local RealtimeViolations at_start;

/// The system's counts for this thread so far.
RealtimeViolations counted_by_system() {
    rusage usage{};
    getrusage(RUSAGE_THREAD, &usage);
    RealtimeViolations counted;
    counted.page_faults = static_cast<std::uint64_t>(usage.ru_minflt + usage.ru_majflt);
    counted.voluntary_switches = static_cast<std::uint64_t>(usage.ru_nvcsw);
    return counted;
}

}  // namespace

RealtimeViolations& RealtimeViolations::operator+=(const RealtimeViolations& other) {
    allocations += other.allocations;
    frees += other.frees;
    locks += other.locks;
    writes += other.writes;
    page_faults += other.page_faults;
    voluntary_switches += other.voluntary_switches;
    return *this;
}

RealtimeTrap::RealtimeTrap() {
    seen = {};
    at_start = counted_by_system();
    trapped = true;
}
RealtimeTrap::~RealtimeTrap() { trapped = false; }

RealtimeViolations RealtimeTrap::violations() const {
    const RealtimeViolations now = counted_by_system();
    RealtimeViolations all = seen;
    all.page_faults = now.page_faults - at_start.page_faults;
    all.voluntary_switches = now.voluntary_switches - at_start.voluntary_switches;
    return all;
}

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)

bool RealtimeTrap::available() { return false; }

}  // namespace aula::test

#else

bool RealtimeTrap::available() { return true; }

namespace {

void count(std::uint64_t RealtimeViolations::*kind) {
    if (trapped) ++(seen.*kind);
}

using MutexLock = int (*)(pthread_mutex_t*);
MutexLock next_mutex_lock = nullptr;

// Before a trap: dlsym() locks and allocates.
__attribute__((constructor)) void find_next() {
    next_mutex_lock = reinterpret_cast<MutexLock>(dlsym(RTLD_NEXT, "pthread_mutex_lock"));
}

}  // namespace

}  // namespace aula::test

using aula::test::count;
using aula::test::RealtimeViolations;

extern "C" {

void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
void __libc_free(void*);

void* malloc(std::size_t size) {
    count(&RealtimeViolations::allocations);
    return __libc_malloc(size);
}

void* calloc(std::size_t number, std::size_t size) {
    count(&RealtimeViolations::allocations);
    return __libc_calloc(number, size);
}

void* realloc(void* p, std::size_t size) {
    count(&RealtimeViolations::allocations);
    return __libc_realloc(p, size);
}

int posix_memalign(void** p, std::size_t alignment, std::size_t size) {
    count(&RealtimeViolations::allocations);
    *p = __libc_memalign(alignment, size);
    return *p == nullptr ? ENOMEM : 0;
}

void* aligned_alloc(std::size_t alignment, std::size_t size) {
    count(&RealtimeViolations::allocations);
    return __libc_memalign(alignment, size);
}

void* memalign(std::size_t alignment, std::size_t size) {
    count(&RealtimeViolations::allocations);
    return __libc_memalign(alignment, size);
}

void free(void* p) {
    if (p != nullptr) count(&RealtimeViolations::frees);
    __libc_free(p);
}

void* mmap(void* address, std::size_t size, int protection, int flags, int file,
           off_t offset) noexcept {
    count(&RealtimeViolations::allocations);
    // NOLINTNEXTLINE(performance-no-int-to-ptr)
    return reinterpret_cast<void*>(
        syscall(SYS_mmap, address, size, protection, flags, file, offset));
}

int munmap(void* p, std::size_t size) noexcept {
    count(&RealtimeViolations::frees);
    return static_cast<int>(syscall(SYS_munmap, p, size));
}

int pthread_mutex_lock(pthread_mutex_t* mutex) noexcept {
    count(&RealtimeViolations::locks);
    if (aula::test::next_mutex_lock == nullptr) aula::test::find_next();  // a library's constructor
    return aula::test::next_mutex_lock(mutex);
}

ssize_t write(int descriptor, const void* bytes, std::size_t size) {
    count(&RealtimeViolations::writes);
    return syscall(SYS_write, descriptor, bytes, size);
}

}  // extern "C"

#endif
