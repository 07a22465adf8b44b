#include "audio/convolution/spectral_loops.h"

namespace aula {

extern const SpectralKernels kPortableKernels;
constinit const SpectralKernels kPortableKernels = kernels_named("portable");

}  // namespace aula
