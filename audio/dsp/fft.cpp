#include "audio/dsp/fft.h"

#include <kiss_fftr.h>

#include <cassert>
#include <new>
#include <type_traits>

namespace aula {

namespace {

struct FreePlan {
    void operator()(kiss_fftr_cfg plan) const { kiss_fftr_free(plan); }
};
using Plan = std::unique_ptr<std::remove_pointer_t<kiss_fftr_cfg>, FreePlan>;

Plan make_plan(std::size_t size, bool inverse) {
    Plan plan(kiss_fftr_alloc(static_cast<int>(size), inverse ? 1 : 0, nullptr, nullptr));
    if (!plan) throw std::bad_alloc();
    return plan;
}

}  // namespace

struct RealFft::Plans {
    Plan forward, inverse;
};

RealFft::RealFft(std::size_t size)
    : size_(size),
      plans_(std::make_unique<Plans>(Plans{make_plan(size, false), make_plan(size, true)})) {
    assert(size == fast_fft_size(size));
}

RealFft::~RealFft() = default;

void RealFft::forward(const float* signal, std::complex<float>* spectrum) {
    kiss_fftr(plans_->forward.get(), signal, reinterpret_cast<kiss_fft_cpx*>(spectrum));
}

void RealFft::inverse(const std::complex<float>* spectrum, float* signal) {
    kiss_fftri(plans_->inverse.get(), reinterpret_cast<const kiss_fft_cpx*>(spectrum), signal);
}

std::size_t fast_fft_size(std::size_t size) {
    return static_cast<std::size_t>(kiss_fftr_next_fast_size_real(static_cast<int>(size)));
}

}  // namespace aula
