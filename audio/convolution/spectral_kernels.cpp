#include "audio/convolution/spectral_kernels.h"

#if defined(__x86_64__)
#include <cpuid.h>
#endif

namespace aula {

extern const SpectralKernels kPortableKernels;
#if defined(__x86_64__)
extern const SpectralKernels kAvx2Kernels;
extern const SpectralKernels kAvx512Kernels;

namespace {

/// Clang 14's __builtin_cpu_supports does not know "f16c".
bool has_f16c() {
    unsigned a = 0;
    unsigned b = 0;
    unsigned c = 0;
    unsigned d = 0;
    return __get_cpuid(1, &a, &b, &c, &d) != 0 && (c & bit_F16C) != 0;
}

}  // namespace
#endif

std::vector<const SpectralKernels*> available_kernels() {
    std::vector<const SpectralKernels*> kernels{&kPortableKernels};
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && has_f16c()) {
        kernels.push_back(&kAvx2Kernels);
    }
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
        __builtin_cpu_supports("avx512dq")) {
        kernels.push_back(&kAvx512Kernels);
    }
#endif
    return kernels;
}

const SpectralKernels& best_kernels() {
    static const SpectralKernels& best = *available_kernels().back();
    return best;
}

}  // namespace aula
