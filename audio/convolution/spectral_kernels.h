#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "aula/audio/realtime.h"

namespace aula {

// A spectrum is stored in chunks of kChunk_bins bins: their real parts, then their imaginary parts.
// Chunks of several spectra may be interleaved; those of one spectrum are then `stride` floats
// apart. All arrays are aligned to kAlignment_bytes.
inline constexpr std::size_t kChunk_bins = 16;
inline constexpr std::size_t kChunk_floats = 2 * kChunk_bins;

/// A term of a sum: the product of an input's spectrum with its filters to all outputs, stored as
/// [chunk][output], times `scale`.
struct SpectralTerm {
    const float* input = nullptr;
    const void* filters = nullptr;  ///< floats, or half-precision numbers
    float scale = 1;
};

/// The terms of a sum. Terms [count, available) of the list are summed next; they are prefetched.
struct SpectralTerms {
    const SpectralTerm* first = nullptr;
    std::size_t count = 0;
    std::size_t available = count;
};

/// The loops of the convolver for one instruction set. [audio thread, wait-free]
struct SpectralKernels {
    const char* name;

    /// Largest number of lanes of a vector.
    std::size_t lanes;

    /// sums += input * filters for all terms, over the chunks [first_chunk, last_chunk). Sums and
    /// filters are stored as [chunk][output]; filters are floats for multiply_add, half-precision
    /// numbers for multiply_add_half.
    using MultiplyAdd = void (*)(const SpectralTerms& terms, std::size_t outputs,
                                 std::size_t first_chunk, std::size_t last_chunk,
                                 float* sums) noexcept AULA_NONBLOCKING;
    MultiplyAdd multiply_add;
    MultiplyAdd multiply_add_half;

    /// out[n] = scale in[n] in half precision, rounded to nearest; `count` is a multiple of
    /// kChunk_bins.
    void (*to_half)(const float* in, std::size_t count, float scale,
                    std::uint16_t* out) noexcept AULA_NONBLOCKING;

    /// The passes of BlockTransform for one vector width. They compute the butterflies
    /// [first, last) of each span.
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

/// The kernels that this CPU supports, from the portable ones to the fastest.
std::vector<const SpectralKernels*> available_kernels();

/// The fastest kernels that this CPU supports.
const SpectralKernels& best_kernels();

}  // namespace aula
