// Compiled once for each instruction set: see spectral_loops.h.
#pragma once

#include <cstddef>

#include "audio/convolution/spectral_kernels.h"
#include "audio/convolution/spectral_vector.h"

namespace aula {

namespace {

struct Floats {
    using Element = float;
    static Vector<kWidest> get(const float* p) { return load<kWidest>(p); }
};
struct Halves {
    using Element = std::uint16_t;
    static Vector<kWidest> get(const std::uint16_t* p) { return load_half(p); }
};

// Vectors of complex sums that stay in registers over all terms, limited by the number of
// registers.
constexpr std::size_t kTile = kWidest == 16 ? 8 : 4;

// Terms by which filters and inputs are prefetched ahead; after a tile's last term follow the first
// ones of the next tile. Summing this many terms takes about as long as a memory access.
constexpr std::size_t kPrefetchDistance = 8;

/// Prefetches kChunks chunks of kCount numbers each, `stride` apart, into the L2 cache: in the L1
/// cache they would displace the operands in use.
template <std::size_t kChunks, std::size_t kCount, typename Element>
[[gnu::always_inline]] inline void prefetch(const Element* from, std::size_t stride) {
    constexpr std::size_t kLine = 64 / sizeof(Element);
    constexpr int kSecondCache = 2;
#pragma GCC unroll 16
    for (std::size_t c = 0; c < kChunks; ++c) {
#pragma GCC unroll 16
        for (std::size_t n = 0; n < kCount; n += kLine) {
            __builtin_prefetch(from + c * stride + n, 0, kSecondCache);
        }
    }
}

/// Sums a tile of kChunks x kOutputs x kParts vectors of kWidest bins; kParts vectors make a chunk.
template <typename Number, std::size_t kChunks, std::size_t kOutputs, std::size_t kParts>
void sum_tile(const SpectralTerms& terms, std::size_t outputs, std::size_t input_offset,
              std::size_t offset, float* sums) {
    using V = Vector<kWidest>;
    const std::size_t stride = outputs * kChunk_floats;
    const std::size_t next_tile = kChunks > 1 ? kChunks * stride : kOutputs * kChunk_floats;
    V re[kChunks][kOutputs][kParts];
    V im[kChunks][kOutputs][kParts];
#pragma GCC unroll 16
    for (std::size_t c = 0; c < kChunks; ++c) {
#pragma GCC unroll 16
        for (std::size_t o = 0; o < kOutputs; ++o) {
#pragma GCC unroll 16
            for (std::size_t p = 0; p < kParts; ++p) {
                const float* const sum =
                    sums + offset + c * stride + o * kChunk_floats + p * kWidest;
                re[c][o][p] = load<kWidest>(sum);
                im[c][o][p] = load<kWidest>(sum + kChunk_bins);
            }
        }
    }
    for (std::size_t k = 0; k < terms.count; ++k) {
        const float* const x = terms.first[k].input + input_offset;
        const auto* const h =
            static_cast<const typename Number::Element*>(terms.first[k].filters) + offset;
        {
            const std::size_t ahead = k + kPrefetchDistance;
            const bool in_tile = ahead < terms.available;
            const SpectralTerm& next = terms.first[in_tile ? ahead : ahead % terms.count];
            prefetch<kChunks, kOutputs * kChunk_floats>(
                static_cast<const typename Number::Element*>(next.filters) + offset +
                    (in_tile ? 0 : next_tile),
                stride);
            prefetch<kChunks, kChunk_floats>(
                next.input + input_offset + (in_tile ? 0 : kChunks * kChunk_floats), kChunk_floats);
        }
#pragma GCC unroll 16
        for (std::size_t c = 0; c < kChunks; ++c) {
#pragma GCC unroll 16
            for (std::size_t p = 0; p < kParts; ++p) {
                const float* const bins = x + c * kChunk_floats + p * kWidest;
                V x_re = load<kWidest>(bins);
                V x_im = load<kWidest>(bins + kChunk_bins);
                x_re *= terms.first[k].scale;
                x_im *= terms.first[k].scale;
#pragma GCC unroll 16
                for (std::size_t o = 0; o < kOutputs; ++o) {
                    const auto* const filter = h + c * stride + o * kChunk_floats + p * kWidest;
                    const V h_re = Number::get(filter);
                    const V h_im = Number::get(filter + kChunk_bins);
                    re[c][o][p] += x_re * h_re;
                    im[c][o][p] += x_re * h_im;
                    re[c][o][p] -= x_im * h_im;
                    im[c][o][p] += x_im * h_re;
                }
            }
        }
    }
#pragma GCC unroll 16
    for (std::size_t c = 0; c < kChunks; ++c) {
#pragma GCC unroll 16
        for (std::size_t o = 0; o < kOutputs; ++o) {
#pragma GCC unroll 16
            for (std::size_t p = 0; p < kParts; ++p) {
                float* const sum = sums + offset + c * stride + o * kChunk_floats + p * kWidest;
                store<kWidest>(re[c][o][p], sum);
                store<kWidest>(im[c][o][p], sum + kChunk_bins);
            }
        }
    }
}

/// Sums a tile of up to kTile vectors, in a loop over the parts of a chunk if all do not fit.
template <typename Number, std::size_t kChunks, std::size_t kOutputs>
void sum_chunks(const SpectralTerms& terms, std::size_t outputs, std::size_t chunk,
                std::size_t output, float* sums) {
    constexpr std::size_t kParts = kChunk_bins / kWidest;
    const std::size_t input_offset = chunk * kChunk_floats;
    const std::size_t offset = (chunk * outputs + output) * kChunk_floats;
    if constexpr (kChunks * kOutputs * kParts <= kTile) {
        sum_tile<Number, kChunks, kOutputs, kParts>(terms, outputs, input_offset, offset, sums);
    } else {
        for (std::size_t part = 0; part < kChunk_bins; part += kWidest) {
            sum_tile<Number, kChunks, kOutputs, 1>(terms, outputs, input_offset + part,
                                                   offset + part, sums);
        }
    }
}

/// Sums groups of kOutputs outputs, then the remaining ones in groups of half the size. If kOutputs
/// is below kTile, several chunks fill the tile.
template <typename Number, std::size_t kOutputs>
void sum_outputs(const SpectralTerms& terms, std::size_t outputs, std::size_t first_chunk,
                 std::size_t last_chunk, std::size_t first_output, float* sums) {
    constexpr std::size_t kChunks = kTile / kOutputs;
    std::size_t chunk = first_chunk;
    for (; chunk + kChunks <= last_chunk; chunk += kChunks) {
        for (std::size_t o = first_output; o + kOutputs <= outputs; o += kOutputs) {
            sum_chunks<Number, kChunks, kOutputs>(terms, outputs, chunk, o, sums);
        }
    }
    for (; chunk < last_chunk; ++chunk) {
        for (std::size_t o = first_output; o + kOutputs <= outputs; o += kOutputs) {
            sum_chunks<Number, 1, kOutputs>(terms, outputs, chunk, o, sums);
        }
    }
    if constexpr (kOutputs > 1) {
        const std::size_t done = first_output + (outputs - first_output) / kOutputs * kOutputs;
        if (done < outputs) {
            sum_outputs<Number, kOutputs / 2>(terms, outputs, first_chunk, last_chunk, done, sums);
        }
    }
}

template <typename Number>
void multiply_add(const SpectralTerms& terms, std::size_t outputs, std::size_t first_chunk,
                  std::size_t last_chunk, float* sums) noexcept AULA_NONBLOCKING {
    if (terms.count == 0) return;
    sum_outputs<Number, kTile>(terms, outputs, first_chunk, last_chunk, 0, sums);
}

}  // namespace

}  // namespace aula
