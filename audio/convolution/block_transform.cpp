#include "audio/convolution/block_transform.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <complex>
#include <numbers>

// Method: right-angle convolution (Crandall and Fagin, "Discrete weighted transforms and
// large-integer arithmetic", 1994).
//
// Let u[0 .. 2M) be the window and u(y) = sum over n of u[n] y^n. Overlap-save needs only the
// powers M .. 2M - 1 of the product of u(y) and the filter's polynomial. They are correct modulo
// y^2M + 1, since the terms that wrap round, negated, fall on the powers below M. The real
// polynomials modulo y^2M + 1 are isomorphic to the complex ones modulo y^M - i, with z[n] = u[n] +
// i u[M + n]. Substituting y = w t, w = exp(i pi / 2M), w^M = i, gives polynomials modulo t^M - 1:
// the M-point discrete Fourier transform of z[n] w^n. M new real samples therefore cost one complex
// transform of M points, no bin needs special treatment, and the result is the imaginary part of
// the inverse transform times w^-n.
//
// The M points are M / L vectors of L lanes, n = L v + l (the four-step decomposition, Bailey
// 1990). With k = k1 + (M / L) k2:
//   Z[k] = sum over l of W_L^(l k2) W_M^(l k1) sum over v of W_(M/L)^(v k1) z[L v + l].
// The inner sums are transforms of whole vectors: the passes, decimated in frequency, without
// reordering of the results. The last step multiplies by W_M^(l k1), transposes squares of L
// vectors so that lanes become vectors, and transforms these. Products of spectra do not depend on
// the order of the bins, so the results stay unordered. The inverse does the same steps in reverse.

namespace aula {

namespace {

// Bins per step; a step takes 0.1 to 0.2 us. Steps at the ends are shorter: they access a window or
// a spectrum that is no longer in the caches, and those at the spectrum transpose.
constexpr std::size_t kMiddlePart = 1024;
constexpr std::size_t kEndPart = 256;

/// There must be at least as many vectors as lanes: the last step transposes squares.
std::size_t lanes_for(std::size_t size, std::size_t max) {
    std::size_t lanes = max;
    while (lanes * lanes > size) lanes /= 2;
    return lanes;
}

const SpectralKernels::Passes& passes_for(const SpectralKernels& kernels, std::size_t lanes) {
    return lanes == 16 ? kernels.passes_16 : lanes == 8 ? kernels.passes_8 : kernels.passes_4;
}

/// exp(-2 pi i numerator / denominator)
std::complex<double> root(std::size_t numerator, std::size_t denominator) {
    return std::polar(1.0, -2 * std::numbers::pi * static_cast<double>(numerator % denominator) /
                               static_cast<double>(denominator));
}

void put(const std::complex<double>& value, std::size_t bin, AlignedVector<float>& chunks) {
    const std::size_t offset = bin / kChunk_bins * kChunk_floats + bin % kChunk_bins;
    chunks[offset] = static_cast<float>(value.real());
    chunks[offset + kChunk_bins] = static_cast<float>(value.imag());
}

}  // namespace

BlockTransform::BlockTransform(std::size_t size, const SpectralKernels& kernels)
    : size_(size), weights_(2 * size), inverse_weights_(2 * size), lane_twiddles_(2 * size) {
    assert(std::has_single_bit(size) && size >= 16 && size <= 8192);
    lanes_ = lanes_for(size, kernels.lanes);
    vectors_ = size / lanes_;
    middle_parts_ = std::max<std::size_t>(1, size / kMiddlePart);
    end_parts_ = std::max<std::size_t>(1, size / kEndPart);
    kernels_ = passes_for(kernels, lanes_);
    starts_with_2_ = std::countr_zero(vectors_) % 2 == 1;

    for (std::size_t n = 0; n < size; ++n) {
        const std::complex<double> w = std::conj(root(n, 4 * size));
        put(w, n, weights_);
        put(std::conj(w) / static_cast<double>(size), n, inverse_weights_);
    }
    // order[v] is the k1 of vector v after all passes: digit reversal of mixed radix.
    std::vector<std::size_t> order(vectors_);
    std::size_t stride = 1;
    for (std::size_t span = vectors_; span > 1;) {
        const std::size_t radix = span == vectors_ && starts_with_2_ ? 2 : 4;
        const std::size_t part = span / radix;
        Pass pass{span, radix, {}};
        for (std::size_t j = 0; j < part; ++j) {
            for (std::size_t m = 1; m < radix; ++m) {
                const std::complex<double> w = root(m * j, span);
                pass.twiddles.push_back(static_cast<float>(w.real()));
                pass.twiddles.push_back(static_cast<float>(w.imag()));
            }
        }
        passes_.push_back(std::move(pass));
        for (std::size_t v = 0; v < vectors_; ++v) order[v] += v % span / part * stride;
        stride *= radix;
        span = part;
    }
    for (std::size_t v = 0; v < vectors_; ++v) {
        for (std::size_t lane = 0; lane < lanes_; ++lane) {
            put(root(lane * order[v], size), v * lanes_ + lane, lane_twiddles_);
        }
    }
}

/// Whole spans if there are at least `parts` of them, otherwise a part of each span's butterflies.
BlockTransform::Range BlockTransform::range(const Pass& pass, std::size_t part,
                                            std::size_t parts) const noexcept {
    const std::size_t butterflies = pass.span / pass.radix;
    if (pass.span * parts <= vectors_) {
        return {part * vectors_ / parts, vectors_ / parts, 0, butterflies};
    }
    return {0, vectors_, part * butterflies / parts, (part + 1) * butterflies / parts};
}

void BlockTransform::forward_step(std::size_t step, const float* older, const float* newer,
                                  float* work, float* spectrum, std::size_t stride) const noexcept {
    if (step < end_parts_) {
        const Range r = range(passes_[0], step, end_parts_);
        kernels_.forward_first(older, newer, weights_.data(), passes_[0].twiddles.data(), vectors_,
                               starts_with_2_, r.first, r.last, work);
        return;
    }
    step -= end_parts_;
    const std::size_t index = 1 + step / middle_parts_;
    if (index < passes_.size()) {
        const Pass& pass = passes_[index];
        const Range r = range(pass, step % middle_parts_, middle_parts_);
        kernels_.forward_middle(pass.twiddles.data(), r.vectors, pass.span, r.first, r.last,
                                work + vector_offset(r.start));
        return;
    }
    step -= (passes_.size() - 1) * middle_parts_;
    const std::size_t vectors = vectors_ / end_parts_;
    const std::size_t start = step * vectors;
    kernels_.forward_last(work + vector_offset(start), lane_twiddles_.data() + vector_offset(start),
                          vectors, spectrum + vector_offset(start, stride), stride);
}

void BlockTransform::forward(const float* older, const float* newer, float* work,
                             float* spectrum) const noexcept {
    for (std::size_t step = 0; step < steps(); ++step) {
        forward_step(step, older, newer, work, spectrum);
    }
}

void BlockTransform::forward_filters(std::span<const float* const> taps, float* work,
                                     float* spectra) const noexcept {
    const std::size_t stride = taps.size() * kChunk_floats;
    const auto step_of = [&](std::size_t filter, std::size_t step) {
        forward_step(step, taps[filter], nullptr, work + filter * work_floats(),
                     spectra + filter * kChunk_floats, stride);
    };
    const std::size_t before_spectra = steps() - end_parts_;
    for (std::size_t f = 0; f < taps.size(); ++f) {
        for (std::size_t step = 0; step < before_spectra; ++step) step_of(f, step);
    }
    for (std::size_t step = before_spectra; step < steps(); ++step) {
        for (std::size_t f = 0; f < taps.size(); ++f) step_of(f, step);
    }
}

void BlockTransform::inverse_step(std::size_t step, const float* spectrum, std::size_t stride,
                                  float* work, float* newer) const noexcept {
    if (step < end_parts_) {
        const std::size_t vectors = vectors_ / end_parts_;
        const std::size_t start = step * vectors;
        kernels_.inverse_first(spectrum + vector_offset(start, stride), stride,
                               lane_twiddles_.data() + vector_offset(start), vectors,
                               work + vector_offset(start));
        return;
    }
    step -= end_parts_;
    const std::size_t done = step / middle_parts_;
    if (done + 1 < passes_.size()) {
        const Pass& pass = passes_[passes_.size() - 1 - done];
        const Range r = range(pass, step % middle_parts_, middle_parts_);
        kernels_.inverse_middle(pass.twiddles.data(), r.vectors, pass.span, r.first, r.last,
                                work + vector_offset(r.start));
        return;
    }
    step -= (passes_.size() - 1) * middle_parts_;
    const Range r = range(passes_[0], step, end_parts_);
    kernels_.inverse_last(inverse_weights_.data(), passes_[0].twiddles.data(), vectors_,
                          starts_with_2_, r.first, r.last, work, newer);
}

void BlockTransform::inverse(const float* spectrum, std::size_t stride, float* work,
                             float* newer) const noexcept {
    for (std::size_t step = 0; step < steps(); ++step) {
        inverse_step(step, spectrum, stride, work, newer);
    }
}

}  // namespace aula
