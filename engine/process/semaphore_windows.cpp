#include "process/semaphore.h"

#include <windows.h>

#include <limits>
#include <new>

namespace aula {

Semaphore::Semaphore(int count)
    : handle_(CreateSemaphoreW(nullptr, count, std::numeric_limits<LONG>::max(), nullptr)) {
    if (handle_ == nullptr) throw std::bad_alloc();
}
Semaphore::~Semaphore() { CloseHandle(handle_); }
void Semaphore::release() noexcept { ReleaseSemaphore(handle_, 1, nullptr); }
void Semaphore::acquire() noexcept { WaitForSingleObject(handle_, INFINITE); }

}  // namespace aula
