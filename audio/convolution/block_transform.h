#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "audio/base/aligned.h"
#include "audio/convolution/spectral_kernels.h"
#include "aula/audio/realtime.h"

namespace aula {

/// The transform under which overlap-save convolution is a product of spectra. A window of 2 M real
/// samples (an older and a newer half) has M complex bins. The product of the spectra of a window
/// and of a filter of M taps, transformed back, gives the newer M samples of their convolution.
/// The bins are in a permuted order that only the inverse with the same kernels reverts. A
/// transform can be split into steps of similar cost that are spread over several calls.
///
/// All buffers except windows and filters are aligned to kAlignment_bytes.
/// [any thread; wait-free except the constructor]
class BlockTransform {
 public:
    /// `size` is M, a power of two from 16 to 8192.
    explicit BlockTransform(std::size_t size, const SpectralKernels& kernels = best_kernels());

    std::size_t size() const { return size_; }
    std::size_t chunks() const { return size_ / kChunk_bins; }
    std::size_t work_floats() const { return 2 * size_; }

    /// Number of steps of a transform in either direction. Steps run in ascending order.
    std::size_t steps() const { return 2 * end_parts_ + (passes_.size() - 1) * middle_parts_; }

    /// One step of the transform of a window of two halves, size() samples each; a null `newer`
    /// means zeros. `work` (work_floats()) holds the intermediate results. The last end_parts_
    /// steps write the spectrum, whose chunks are `stride` floats apart.
    void forward_step(std::size_t step, const float* older, const float* newer, float* work,
                      float* spectrum,
                      std::size_t stride = kChunk_floats) const noexcept AULA_NONBLOCKING;

    /// All steps of the transform of a window. `spectrum` has 2 size() floats.
    void forward(const float* older, const float* newer, float* work,
                 float* spectrum) const noexcept AULA_NONBLOCKING;

    /// Transforms filters of size() taps each into interleaved spectra, [chunk][filter]. The
    /// spectra are written in ascending order of chunks. `work` has work_floats() per filter.
    void forward_filters(std::span<const float* const> taps, float* work,
                         float* spectra) const noexcept AULA_NONBLOCKING;

    /// One step of the inverse. The last steps write `newer`, the newer half of the window, size()
    /// samples.
    void inverse_step(std::size_t step, const float* spectrum, std::size_t stride, float* work,
                      float* newer) const noexcept AULA_NONBLOCKING;
    void inverse(const float* spectrum, std::size_t stride, float* work,
                 float* newer) const noexcept AULA_NONBLOCKING;

 private:
    /// A pass of butterflies of `radix` vectors that are span / radix vectors apart.
    struct Pass {
        std::size_t span;
        std::size_t radix;
        std::vector<float> twiddles;
    };
    /// A part of a pass: butterflies [first, last) of each span in the vectors
    /// [start, start + vectors).
    struct Range {
        std::size_t start, vectors, first, last;
    };
    Range range(const Pass& pass, std::size_t part,
                std::size_t parts) const noexcept AULA_NONBLOCKING;
    std::size_t vector_offset(std::size_t vector,
                              std::size_t stride = kChunk_floats) const noexcept AULA_NONBLOCKING {
        return vector * lanes_ / kChunk_bins * stride + vector * lanes_ % kChunk_bins;
    }

    std::size_t size_;
    std::size_t lanes_;
    std::size_t vectors_;
    std::size_t end_parts_;     ///< steps of the pass at the window and of that at the spectrum
    std::size_t middle_parts_;  ///< steps of each other pass
    SpectralKernels::Passes kernels_;
    bool starts_with_2_ = false;  ///< the first pass is radix 2
    std::vector<Pass> passes_;    ///< in the forward direction
    AlignedVector<float> weights_;
    AlignedVector<float> inverse_weights_;
    AlignedVector<float> lane_twiddles_;
};

}  // namespace aula
