// The loops behind SpectralKernels. Each source file that includes this one compiles them for an
// instruction set of its own, so everything is local to it and nothing inline comes from elsewhere:
// the linker must not mix instruction sets.
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
