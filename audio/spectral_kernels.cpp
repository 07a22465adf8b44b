#include "audio/spectral_kernels.h"

namespace aula {

extern const SpectralKernels kPortableKernels;
#if defined(__x86_64__)
extern const SpectralKernels kAvx2Kernels;
extern const SpectralKernels kAvx512Kernels;
#endif

std::vector<const SpectralKernels*> available_kernels() {
    std::vector<const SpectralKernels*> kernels{&kPortableKernels};
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
        __builtin_cpu_supports("f16c")) {
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
