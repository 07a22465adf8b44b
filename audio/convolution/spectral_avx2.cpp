#include "audio/convolution/spectral_loops.h"

namespace aula {

extern const SpectralKernels kAvx2Kernels;
constinit const SpectralKernels kAvx2Kernels = kernels_named("avx2");

}  // namespace aula
