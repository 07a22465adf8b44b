#include "audio/convolution/spectral_kernels.h"

#include "process/instruction_set.h"

namespace aula {

extern const SpectralKernels kPortableKernels;
#if defined(__x86_64__)
extern const SpectralKernels kAvx2Kernels;
extern const SpectralKernels kAvx512Kernels;
#endif

std::vector<const SpectralKernels*> available_kernels() {
    std::vector<const SpectralKernels*> kernels{&kPortableKernels};
#if defined(__x86_64__)
    if (kBestInstructionSet >= InstructionSet::kAvx2) kernels.push_back(&kAvx2Kernels);
    if (kBestInstructionSet >= InstructionSet::kAvx512) kernels.push_back(&kAvx512Kernels);
#endif
    return kernels;
}

const SpectralKernels& best_kernels() {
    static const SpectralKernels& best = *available_kernels().back();
    return best;
}

}  // namespace aula
