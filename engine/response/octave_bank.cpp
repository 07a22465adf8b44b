#include "engine/response/octave_bank.h"

#include <cassert>
#include <cmath>
#include <cstring>
#include <numbers>

#include "process/multiversion.h"

namespace aula {
// A Butterworth low-pass and high-pass of odd order N at the same edge are half the sum and half
// the difference of two all-passes U and V that share the poles -cos(k pi/N) +- j sin(k pi/N),
// k = 0..(N-1)/2: U has the even k (with the real pole), V the odd ones. Then
//     |LP|^2 + |HP|^2 = (|U + V|^2 + |U - V|^2) / 4 = (|U|^2 + |V|^2) / 2 = 1
// for any rounding of the poles, and LP + HP = U. The edges are applied in ascending order, each to
// the high-pass output of the previous one, so the powers of all bands sum to 1. Every band below
// an edge also passes that edge's U: the sum of all bands is then the product of all U, an
// all-pass.
OctaveBank::OctaveBank(double sample_rate_hz) {
    assert(sample_rate_hz > 0);
    for (std::size_t b = 0; b + 1 < kBandCount; ++b) {
        const double edge_hz = 1000 * std::pow(2.0, static_cast<double>(b) - 3.5);
        if (edge_hz >= sample_rate_hz / 2) break;
        // The bilinear transform of an analog pole s: z = (1 + w s)/(1 - w s), w prewarped.
        const double w = std::tan(std::numbers::pi * edge_hz / sample_rate_hz);
        Edge edge;
        edge.u.real.a1 = -(1 - w) / (1 + w);
        for (int k = 1; k <= kOrder / 2; ++k) {
            const double c = std::cos(k * std::numbers::pi / kOrder);
            const double d = 1 + 2 * w * c + w * w;
            const double a1 = 2 * (w * w - 1) / d;
            const double a2 = (1 - 2 * w * c + w * w) / d;
            const auto i = static_cast<std::size_t>(k - 1) / 2;
            if (k % 2 == 0) {
                edge.u.pairs[i] = {a1, a2};
            } else {
                edge.v.pairs[i] = {a1, a2};
            }
        }
        edges_.push_back(edge);
    }
}

/// Edge by edge, so that the processor overlaps the recurrences of consecutive samples. All-passes
/// of bands above the edge process zeros.
AULA_MULTIVERSION
void OctaveBank::split(std::span<Edge> edges, std::span<BandSample> bands) {
    for (std::size_t b = 0; b < edges.size(); ++b) {
        Edge edge = edges[b];
        for (BandSample& sample : bands) {
            const double v = edge.v.process(sample[b]);
            BandDoubles all;
            std::memcpy(&all, sample.data(), sizeof all);
            all = edge.u.process(all);
            std::memcpy(sample.data(), &all, sizeof all);
            const double u = sample[b];
            sample[b] = (u + v) / 2;
            sample[b + 1] = (u - v) / 2;
        }
        edges[b] = edge;
    }
}

std::vector<std::array<double, kBandCount>> OctaveBank::process(std::span<const double> signal) {
    std::vector<BandSample> bands(signal.size());
    for (std::size_t n = 0; n < signal.size(); ++n) bands[n][0] = signal[n];
    best_version<split>(std::span(edges_), std::span(bands));
    return bands;
}

}  // namespace aula
