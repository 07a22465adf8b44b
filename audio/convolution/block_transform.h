#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "audio/base/aligned.h"
#include "audio/base/realtime.h"
#include "audio/convolution/spectral_kernels.h"

namespace aula {

/// The transform under which partitioned convolution is a product of spectra. A window of 2 M real
/// samples, the older and the newer half, has M complex bins; the product of a window's spectrum
/// with that of a filter of M taps, transformed back, has the newer M samples of their convolution.
/// The bins are not frequencies in order: they mean something only to the inverse with the same
/// kernels. A transform can be done in steps of like cost, spread over calls.
///
/// Buffers must be aligned to kAlignment_bytes, but for windows and filters. Objects are not
/// changed by use. [any thread, wait-free but for the constructor]
class BlockTransform {
 public:
    /// `size` is M, a power of two from 16 to 8192.
    explicit BlockTransform(std::size_t size, const SpectralKernels& kernels = best_kernels());

    std::size_t size() const { return size_; }
    std::size_t chunks() const { return size_ / kChunk_bins; }
    std::size_t work_floats() const { return 2 * size_; }

    /// Steps of a transform in either direction, to be done in order.
    std::size_t steps() const { return 2 * end_parts_ + (passes_.size() - 1) * middle_parts_; }

    /// Spectrum of a window. The last step writes the spectrum, whose chunks are `stride` floats
    /// apart; what steps hand on lies in `work`.
    void forward_step(std::size_t step, const float* older, const float* newer, float* work,
                      float* spectrum,
                      std::size_t stride = kChunk_floats) const noexcept AULA_NONBLOCKING;

    /// All steps for a window.
    void forward(const float* older, const float* newer, float* work,
                 float* spectrum) const noexcept AULA_NONBLOCKING;

    /// All steps for filters of size() taps each, whose spectra are interleaved: [chunk][filter].
    /// A few chunks of all are written before those that follow. `work` has work_floats() for each.
    void forward_filters(std::span<const float* const> taps, float* work,
                         float* spectra) const noexcept AULA_NONBLOCKING;

    /// The newer half of a window, size() samples, written by the last step.
    void inverse_step(std::size_t step, const float* spectrum, std::size_t stride, float* work,
                      float* newer) const noexcept AULA_NONBLOCKING;
    void inverse(const float* spectrum, std::size_t stride, float* work,
                 float* newer) const noexcept AULA_NONBLOCKING;

 private:
    /// Butterflies of `radix` vectors that are span / radix apart.
    struct Pass {
        std::size_t span;
        std::size_t radix;
        std::vector<float> twiddles;
    };
    /// A part of a pass: butterflies first to last - 1 of each of the spans in `vectors` vectors
    /// from `start` on.
    struct Range {
        std::size_t start, vectors, first, last;
    };
    Range range(const Pass& pass, std::size_t part,
                std::size_t parts) const noexcept AULA_NONBLOCKING;
    std::size_t place(std::size_t vector,
                      std::size_t stride = kChunk_floats) const noexcept AULA_NONBLOCKING {
        return vector * lanes_ / kChunk_bins * stride + vector * lanes_ % kChunk_bins;
    }

    std::size_t size_;
    std::size_t lanes_;
    std::size_t vectors_;
    std::size_t end_parts_;     ///< steps of the pass over the window, and at the spectrum
    std::size_t middle_parts_;  ///< steps of each pass between
    SpectralKernels::Passes kernels_;
    bool starts_with_2_ = false;  ///< the first pass has butterflies of two
    std::vector<Pass> passes_;    ///< in the forward direction
    AlignedVector<float> weights_;
    AlignedVector<float> inverse_weights_;
    AlignedVector<float> lane_twiddles_;
};

}  // namespace aula
