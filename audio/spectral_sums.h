// Compiled once for each instruction set: see spectral_loops.h.
#pragma once

#include <cstddef>

#include "audio/spectral_kernels.h"
#include "audio/spectral_vector.h"

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

// Complex sums of a vector each that stay in registers over all terms: what the instruction set has
// registers for.
constexpr std::size_t kTile = kWidest == 16 ? 8 : 4;

// How many terms ahead filters are fetched: the time to do so many is that of an access to the
// cache of the last level.
constexpr std::size_t kFetchAhead = 4;

/// kChunks x kOutputs x kParts vectors of kWidest bins, a part being such a piece of a chunk.
template <typename Number, std::size_t kChunks, std::size_t kOutputs, std::size_t kParts>
void sum_tile(const SpectralTerm* terms, std::size_t count, std::size_t outputs,
              std::size_t input_offset, std::size_t offset, float* sums) {
    using V = Vector<kWidest>;
    constexpr bool kScaled = sizeof(typename Number::Element) == 2;
    const std::size_t stride = outputs * kChunk_floats;
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
    for (std::size_t k = 0; k < count; ++k) {
        const float* const x = terms[k].input + input_offset;
        const auto* const h =
            static_cast<const typename Number::Element*>(terms[k].filters) + offset;
        if (k + kFetchAhead < count) {
            const auto* const next =
                static_cast<const typename Number::Element*>(terms[k + kFetchAhead].filters) +
                offset;
#pragma GCC unroll 16
            for (std::size_t c = 0; c < kChunks; ++c) {
                constexpr std::size_t kLine = 64 / sizeof(typename Number::Element);
#pragma GCC unroll 16
                for (std::size_t n = 0; n < kOutputs * kChunk_floats; n += kLine) {
                    __builtin_prefetch(next + c * stride + n);
                }
            }
        }
#pragma GCC unroll 16
        for (std::size_t c = 0; c < kChunks; ++c) {
#pragma GCC unroll 16
            for (std::size_t p = 0; p < kParts; ++p) {
                const float* const bins = x + c * kChunk_floats + p * kWidest;
                V x_re = load<kWidest>(bins);
                V x_im = load<kWidest>(bins + kChunk_bins);
                if constexpr (kScaled) {
                    x_re *= terms[k].scale;
                    x_im *= terms[k].scale;
                }
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

/// A tile of up to kTile vectors; what a chunk has too many of in its parts is looped over.
template <typename Number, std::size_t kChunks, std::size_t kOutputs>
void sum_chunks(const SpectralTerm* terms, std::size_t count, std::size_t outputs,
                std::size_t chunk, std::size_t output, float* sums) {
    constexpr std::size_t kParts = kChunk_bins / kWidest;
    const std::size_t input_offset = chunk * kChunk_floats;
    const std::size_t offset = (chunk * outputs + output) * kChunk_floats;
    if constexpr (kChunks * kOutputs * kParts <= kTile) {
        sum_tile<Number, kChunks, kOutputs, kParts>(terms, count, outputs, input_offset, offset,
                                                    sums);
    } else {
        for (std::size_t part = 0; part < kChunk_bins; part += kWidest) {
            sum_tile<Number, kChunks, kOutputs, 1>(terms, count, outputs, input_offset + part,
                                                   offset + part, sums);
        }
    }
}

/// Outputs in groups that fill a tile, then what is left in halves of it; for few outputs the tile
/// is filled by several chunks.
template <typename Number, std::size_t kOutputs>
void sum_outputs(const SpectralTerm* terms, std::size_t count, std::size_t outputs,
                 std::size_t first_chunk, std::size_t last_chunk, std::size_t first_output,
                 float* sums) {
    constexpr std::size_t kChunks = kTile / kOutputs;
    std::size_t chunk = first_chunk;
    for (; chunk + kChunks <= last_chunk; chunk += kChunks) {
        for (std::size_t o = first_output; o + kOutputs <= outputs; o += kOutputs) {
            sum_chunks<Number, kChunks, kOutputs>(terms, count, outputs, chunk, o, sums);
        }
    }
    for (; chunk < last_chunk; ++chunk) {
        for (std::size_t o = first_output; o + kOutputs <= outputs; o += kOutputs) {
            sum_chunks<Number, 1, kOutputs>(terms, count, outputs, chunk, o, sums);
        }
    }
    if constexpr (kOutputs > 1) {
        const std::size_t done = first_output + (outputs - first_output) / kOutputs * kOutputs;
        if (done < outputs) {
            sum_outputs<Number, kOutputs / 2>(terms, count, outputs, first_chunk, last_chunk, done,
                                              sums);
        }
    }
}

template <typename Number>
void multiply_add(const SpectralTerm* terms, std::size_t count, std::size_t outputs,
                  std::size_t first_chunk, std::size_t last_chunk, float* sums) {
    if (count == 0) return;
    sum_outputs<Number, kTile>(terms, count, outputs, first_chunk, last_chunk, 0, sums);
}

}  // namespace

}  // namespace aula
