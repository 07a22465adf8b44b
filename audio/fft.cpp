#include "audio/fft.h"

#include <cassert>
#include <cstdint>
#include <mutex>

#include "audio/aligned.h"

#ifdef AULA_FFT_KISSFFT
#include <kiss_fftr.h>
#else
#include <fftw3.h>
#endif

namespace aula {

namespace {

[[maybe_unused]] bool is_aligned(const void* p) {
    return reinterpret_cast<std::uintptr_t>(p) % kAlignment_bytes == 0;
}

}  // namespace

#ifdef AULA_FFT_KISSFFT

struct RealFft::Plans {
    explicit Plans(std::size_t size)
        : forward(kiss_fftr_alloc(static_cast<int>(size), 0, nullptr, nullptr)),
          inverse(kiss_fftr_alloc(static_cast<int>(size), 1, nullptr, nullptr)) {
        if (forward == nullptr || inverse == nullptr) throw std::bad_alloc();
    }
    ~Plans() {
        kiss_fftr_free(forward);
        kiss_fftr_free(inverse);
    }
    Plans(const Plans&) = delete;
    Plans& operator=(const Plans&) = delete;

    kiss_fftr_cfg forward;
    kiss_fftr_cfg inverse;
};

void RealFft::forward(const float* signal, std::complex<float>* spectrum) noexcept {
    assert(is_aligned(signal) && is_aligned(spectrum));
    kiss_fftr(plans_->forward, signal, reinterpret_cast<kiss_fft_cpx*>(spectrum));
}

void RealFft::inverse(std::complex<float>* spectrum, float* signal) noexcept {
    assert(is_aligned(signal) && is_aligned(spectrum));
    kiss_fftri(plans_->inverse, reinterpret_cast<const kiss_fft_cpx*>(spectrum), signal);
}

#else

namespace {

// FFTW's planner keeps global tables; only executing a plan is thread-safe.
std::mutex& planner_mutex() {
    static std::mutex mutex;
    return mutex;
}

}  // namespace

struct RealFft::Plans {
    explicit Plans(std::size_t size) {
        AlignedVector<float> signal(size);
        AlignedVector<std::complex<float> > spectrum(size / 2 + 1);
        auto* bins = reinterpret_cast<fftwf_complex*>(spectrum.data());
        const std::lock_guard lock(planner_mutex());
        // Measuring would choose another algorithm, and other rounding, from run to run.
        const int n = static_cast<int>(size);
        forward = fftwf_plan_dft_r2c_1d(n, signal.data(), bins, FFTW_ESTIMATE);
        inverse = fftwf_plan_dft_c2r_1d(n, bins, signal.data(), FFTW_ESTIMATE);
        assert(forward != nullptr && inverse != nullptr);
    }
    ~Plans() {
        const std::lock_guard lock(planner_mutex());
        fftwf_destroy_plan(forward);
        fftwf_destroy_plan(inverse);
    }
    Plans(const Plans&) = delete;
    Plans& operator=(const Plans&) = delete;

    fftwf_plan forward;
    fftwf_plan inverse;
};

void RealFft::forward(const float* signal, std::complex<float>* spectrum) noexcept {
    assert(is_aligned(signal) && is_aligned(spectrum));
    // A real transform out of place leaves its input alone.
    fftwf_execute_dft_r2c(plans_->forward, const_cast<float*>(signal),
                          reinterpret_cast<fftwf_complex*>(spectrum));
}

void RealFft::inverse(std::complex<float>* spectrum, float* signal) noexcept {
    assert(is_aligned(signal) && is_aligned(spectrum));
    fftwf_execute_dft_c2r(plans_->inverse, reinterpret_cast<fftwf_complex*>(spectrum), signal);
}

#endif

RealFft::RealFft(std::size_t size) : size_(size), plans_(std::make_unique<Plans>(size)) {
    assert(size >= 2 && size % 2 == 0);
}
RealFft::~RealFft() = default;
RealFft::RealFft(RealFft&&) noexcept = default;
RealFft& RealFft::operator=(RealFft&&) noexcept = default;

std::size_t fast_fft_size(std::size_t size) {
    for (std::size_t n = size + size % 2;; n += 2) {
        std::size_t rest = n;
        for (const std::size_t factor : {2U, 3U, 5U}) {
            while (rest > 1 && rest % factor == 0) rest /= factor;
        }
        if (rest == 1) return n;
    }
}

}  // namespace aula
