#include "aula/audio/realtime.h"

#include <cstdint>

#if defined(__SSE__)
#include <xmmintrin.h>
#endif

namespace aula {

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
FlushDenormals::~FlushDenormals() noexcept { set_floating_point_control(saved_); }

}  // namespace aula
