#pragma once

#include <span>
#include <vector>

namespace aula {

/// A frequency band of a filter bank, with its edges at -3 dB.
struct FrequencyBand {
    double low_hz = 0;
    double high_hz = 0;

    /// A band of 1 / `per_octave` octave about the centre with the number `index`, 0 at 1 kHz; base
    /// ten (IEC 61260-1). `per_octave` is 1 or 3.
    static FrequencyBand at(int index, int per_octave);

    double width_hz() const { return high_hz - low_hz; }

    /// Time in which the filter of the band decays by 60 dB.
    double ringing_s() const { return 3.8 / width_hz(); }
};

/// The signal filtered to a band without delay: forwards and backwards by a Butterworth band-pass
/// of order 3, whose edges lie so that both passes together have -3 dB at those of the band. Two
/// bands of an octave next to each other are 32 dB apart at their centres (IEC 61260-1, class 1).
/// The result begins `ahead` samples before the signal, with what the backward pass rings. The
/// upper edge is below half of the sample rate.
std::vector<double> band_passed(std::span<const float> signal, double sample_rate_hz,
                                const FrequencyBand& band, std::size_t ahead);

}  // namespace aula
