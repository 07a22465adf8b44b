#pragma once

#include <array>
#include <span>
#include <vector>

#include "engine/base/band_vector.h"

namespace aula {

/// Splits a signal into octave bands by Butterworth crossovers built from all-passes. The lowest
/// band extends down to 0 Hz, the highest up to the Nyquist frequency; bands above it are silent.
/// The power responses of the bands sum to 1 at every frequency. The sum of the bands is the input
/// filtered by an all-pass. [one thread]
class OctaveBank {
 public:
    explicit OctaveBank(double sample_rate_hz);

    /// The bands of the next samples of the signal: [sample][band].
    std::vector<std::array<double, kBandCount>> process(std::span<const double> signal);

 private:
    // The filters process one signal (Sample is double) or one in each band (BandDoubles).

    /// First-order all-pass (a1 + 1/z) / (1 + a1/z), 1 at 0 Hz.
    template <typename Sample>
    struct AllPass1 {
        double a1 = 0;
        Sample x1{}, y1{};

        [[gnu::always_inline]] Sample process(const Sample& x) {
            y1 = a1 * (x - y1) + x1;
            x1 = x;
            return y1;
        }
    };
    /// Second-order all-pass (a2 + a1/z + 1/z2) / (1 + a1/z + a2/z2), 1 at 0 Hz.
    template <typename Sample>
    struct AllPass2 {
        double a1 = 0, a2 = 0;
        Sample x1{}, x2{}, y1{}, y2{};

        [[gnu::always_inline]] Sample process(const Sample& x) {
            const Sample y = a2 * (x - y2) + a1 * (x1 - y1) + x2;
            x2 = x1, x1 = x;
            y2 = y1, y1 = y;
            return y;
        }
    };
    static constexpr int kOrder = 15;  ///< of the low- and high-passes: 90 dB per octave
    /// The all-passes of an edge: low-pass (u + v)/2, high-pass (u - v)/2.
    struct U {
        AllPass1<BandDoubles> real;
        std::array<AllPass2<BandDoubles>, kOrder / 4> pairs;

        [[gnu::always_inline]] BandDoubles process(BandDoubles x) {
            x = real.process(x);
            for (auto& pair : pairs) x = pair.process(x);
            return x;
        }
    };
    struct V {
        std::array<AllPass2<double>, (kOrder + 1) / 4> pairs;

        [[gnu::always_inline]] double process(double x) {
            for (auto& pair : pairs) x = pair.process(x);
            return x;
        }
    };
    struct alignas(64) Edge {  // GCC 12 allocates vectors of doubles for SSE
        U u;                   ///< also of the bands below the edge
        V v;
    };
    using BandSample = std::array<double, kBandCount>;
    /// Splits samples, whose signal is in the lowest band.
    static void split(std::span<Edge> edges, std::span<BandSample> bands);

    std::vector<Edge> edges_;
};

}  // namespace aula
