#include "audio/convolution/spectral_loops.h"

namespace aula {

extern const SpectralKernels kAvx512Kernels;
constinit const SpectralKernels kAvx512Kernels = kernels_named("avx512");

}  // namespace aula
