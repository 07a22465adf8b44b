#include "apps/bench/convolution/fft_libraries.h"

#include <memory>
#include <type_traits>

#include "audio/base/aligned.h"
#include "audio/dsp/fft.h"

#ifdef AULA_BENCH_FFTW
#include <fftw3.h>
#endif

namespace aula::bench {

namespace {

#ifdef AULA_BENCH_FFTW
// The library may spend time on finding its fastest plan.
FftPair plan_fftw(std::size_t size) {
    AlignedVector<float> signal(size);
    AlignedVector<std::complex<float>> spectrum(size / 2 + 1);
    auto* const bins = reinterpret_cast<fftwf_complex*>(spectrum.data());
    const int n = static_cast<int>(size);
    using Plan = std::shared_ptr<std::remove_pointer_t<fftwf_plan>>;
    const Plan forward(fftwf_plan_dft_r2c_1d(n, signal.data(), bins, FFTW_MEASURE),
                       fftwf_destroy_plan);
    const Plan inverse(fftwf_plan_dft_c2r_1d(n, bins, signal.data(), FFTW_MEASURE),
                       fftwf_destroy_plan);
    return {[forward](const float* in, std::complex<float>* out) {
                fftwf_execute_dft_r2c(forward.get(), const_cast<float*>(in),
                                      reinterpret_cast<fftwf_complex*>(out));
            },
            [inverse](std::complex<float>* in, float* out) {
                fftwf_execute_dft_c2r(inverse.get(), reinterpret_cast<fftwf_complex*>(in), out);
            }};
}
#endif

FftPair plan_kissfft(std::size_t size) {
    const auto fft = std::make_shared<RealFft>(size);
    return {[fft](const float* in, std::complex<float>* out) { fft->forward(in, out); },
            [fft](std::complex<float>* in, float* out) { fft->inverse(in, out); }};
}

}  // namespace

std::vector<FftLibrary> fft_libraries() {
    std::vector<FftLibrary> libraries;
#ifdef AULA_BENCH_FFTW
    libraries.push_back({"fftw", plan_fftw});
#endif
    libraries.push_back({"kissfft", plan_kissfft});
    return libraries;
}

}  // namespace aula::bench
