#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "aula/engine/bands.h"

namespace aula {

/// Splits a signal into octave bands by Butterworth crossovers built from all-passes. The lowest
/// band extends down to 0 Hz, the highest up to the Nyquist frequency; bands above it are silent.
/// The power responses of the bands sum to 1 at every frequency. The sum of the bands is the input
/// filtered by an all-pass. [one thread]
class OctaveBank {
 public:
    explicit OctaveBank(double sample_rate_hz);

    /// The next sample of every band.
    std::array<double, kBandCount> process(double x);

 private:
    /// First-order all-pass (a1 + 1/z) / (1 + a1/z), 1 at 0 Hz.
    struct AllPass1 {
        double a1 = 0;
        double x1 = 0, y1 = 0;

        double process(double x) {
            y1 = a1 * (x - y1) + x1;
            x1 = x;
            return y1;
        }
    };
    /// Second-order all-pass (a2 + a1/z + 1/z2) / (1 + a1/z + a2/z2), 1 at 0 Hz.
    struct AllPass2 {
        double a1 = 0, a2 = 0;
        double x1 = 0, x2 = 0, y1 = 0, y2 = 0;

        double process(double x) {
            const double y = a2 * (x - y2) + a1 * (x1 - y1) + x2;
            x2 = x1, x1 = x;
            y2 = y1, y1 = y;
            return y;
        }
    };
    static constexpr int kOrder = 15;  ///< of the low- and high-passes: 90 dB per octave
    /// The all-passes of an edge: low-pass (u + v)/2, high-pass (u - v)/2.
    struct Odd {
        AllPass1 real;
        std::array<AllPass2, kOrder / 4> pairs;

        double process(double x) {
            x = real.process(x);
            for (AllPass2& pair : pairs) x = pair.process(x);
            return x;
        }
    };
    struct Even {
        std::array<AllPass2, (kOrder + 1) / 4> pairs;

        double process(double x) {
            for (AllPass2& pair : pairs) x = pair.process(x);
            return x;
        }
    };
    struct Edge {
        Odd u;
        Even v;
        std::vector<Odd> below;  ///< [band below the edge] copy of u
    };
    std::vector<Edge> edges_;
};

}  // namespace aula
