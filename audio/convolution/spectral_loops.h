// The loops of SpectralKernels. Each source file that includes this header compiles them for
// another instruction set. All definitions have internal linkage and no inline function of another
// header is used, so that the linker cannot mix instruction sets.
#pragma once

#include "audio/convolution/spectral_kernels.h"
#include "audio/convolution/spectral_sums.h"
#include "audio/convolution/spectral_transform.h"
#include "audio/convolution/spectral_vector.h"

namespace aula {

namespace {

constexpr SpectralKernels kernels_named(const char* name) {
    return {name,
            kWidest,
            multiply_add<Floats>,
            multiply_add<Halves>,
            to_half,
            Transform<4>::kPasses,
            Transform<(kWidest < 8 ? kWidest : 8)>::kPasses,
            Transform<kWidest>::kPasses};
}

}  // namespace

}  // namespace aula
