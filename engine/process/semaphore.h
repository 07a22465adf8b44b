#pragma once

#include <semaphore>

namespace aula {

#if defined(_WIN32)
/// As std::counting_semaphore, which in libstdc++ 12 on Windows loses a release() that comes while
/// another thread begins to wait (atomic_wait.h compares before it locks).
class Semaphore {
 public:
    explicit Semaphore(int count);
    ~Semaphore();
    Semaphore(const Semaphore&) = delete;
    Semaphore& operator=(const Semaphore&) = delete;

    void release() noexcept;
    void acquire() noexcept;

 private:
    void* handle_;
};
#else
using Semaphore = std::counting_semaphore<>;
#endif

}  // namespace aula
