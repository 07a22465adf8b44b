#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "audio/base/realtime.h"

namespace aula {

// A spectrum is stored in chunks of kChunk_bins bins: their real parts, then their imaginary parts.
// The chunks of several spectra may be interleaved: chunks of one spectrum are `stride` floats
// apart. All arrays are aligned to kAlignment_bytes.
inline constexpr std::size_t kChunk_bins = 16;
inline constexpr std::size_t kChunk_floats = 2 * kChunk_bins;

/// A product to be summed: an input's spectrum with filters of it to all outputs, the chunks of the
/// outputs interleaved. Filters are floats, or half-precision numbers to be multiplied by `scale`.
struct SpectralTerm {
    const float* input = nullptr;
    const void* filters = nullptr;
    float scale = 1;
};

/// Products to be summed, and how many follow in the list from the first on: those beyond `count`
/// are to be summed next.
struct SpectralTerms {
    const SpectralTerm* first = nullptr;
    std::size_t count = 0;
    std::size_t known = count;
};

/// The loops of the convolver for one instruction set. [audio thread, wait-free]
struct SpectralKernels {
    const char* name;

    /// Most lanes of the transforms' vectors.
    std::size_t lanes;

    /// sums += input * filters for all terms, over a range of chunks: sums and filters are stored
    /// as [chunk][output]. The terms' filters are floats, or half precision for the second.
    using MultiplyAdd = void (*)(const SpectralTerms& terms, std::size_t outputs,
                                 std::size_t first_chunk, std::size_t last_chunk,
                                 float* sums) noexcept AULA_NONBLOCKING;
    MultiplyAdd multiply_add;
    MultiplyAdd multiply_add_half;

    /// Half-precision numbers, rounded to nearest; `count` is a multiple of kChunk_bins.
    void (*to_half)(const float* in, std::size_t count, float scale,
                    std::uint16_t* out) noexcept AULA_NONBLOCKING;

    /// The passes of BlockTransform for one width of vectors; see there. Butterflies first to last
    /// - 1 of a span are done.
    struct Passes {
        void (*forward_first)(const float* older, const float* newer, const float* weights,
                              const float* twiddles, std::size_t vectors, bool radix_2,
                              std::size_t first, std::size_t last,
                              float* work) noexcept AULA_NONBLOCKING;
        void (*forward_middle)(const float* twiddles, std::size_t vectors, std::size_t span,
                               std::size_t first, std::size_t last,
                               float* work) noexcept AULA_NONBLOCKING;
        void (*forward_last)(const float* work, const float* twiddles, std::size_t vectors,
                             float* spectrum, std::size_t stride) noexcept AULA_NONBLOCKING;
        void (*inverse_first)(const float* spectrum, std::size_t stride, const float* twiddles,
                              std::size_t vectors, float* work) noexcept AULA_NONBLOCKING;
        void (*inverse_middle)(const float* twiddles, std::size_t vectors, std::size_t span,
                               std::size_t first, std::size_t last,
                               float* work) noexcept AULA_NONBLOCKING;
        void (*inverse_last)(const float* weights, const float* twiddles, std::size_t vectors,
                             bool radix_2, std::size_t first, std::size_t last, const float* work,
                             float* out) noexcept AULA_NONBLOCKING;
    };
    Passes passes_4;
    Passes passes_8;   ///< if lanes >= 8
    Passes passes_16;  ///< if lanes >= 16
};

/// Those that this machine can run: the portable ones first, the fastest last.
std::vector<const SpectralKernels*> available_kernels();

/// The fastest.
const SpectralKernels& best_kernels();

}  // namespace aula
