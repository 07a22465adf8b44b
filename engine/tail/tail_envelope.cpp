#include "engine/tail/tail_envelope.h"

#include <algorithm>
#include <cmath>

#include "process/multiversion.h"

namespace aula {
namespace {

using Values = TailSegment::Values;

// A faster change than about a period of the centre frequency would spread a carrier's spectrum
// into other octaves. A bin's energy is therefore spread over its duration and a period after it (1
// ms at 1 kHz, 16 ms at 63 Hz: less than the duration of the octave filter's response).
std::vector<Bands> spread_in_time(const EnergyResponse& energy) {
    const TimeBins& bins = energy.bins;
    std::vector<Bands> out(bins.count());
    for (std::size_t b = 0; b < kBandCount; ++b) {
        const double period_s = 1 / double{kBandCentres_hz[b]};
        for (std::size_t i = 0; i < bins.count(); ++i) {
            const double begin_s = bins.begin_s(i);
            const double end_s = bins.end_s(i) + period_s;
            for (std::size_t k = i; k < bins.count() && bins.begin_s(k) < end_s; ++k) {
                const double overlap_s = std::min(end_s, bins.end_s(k)) - bins.begin_s(k);
                out[k][b] +=
                    energy.energy[i][b] * static_cast<float>(overlap_s / (end_s - begin_s));
            }
        }
    }
    return out;
}

/// Sets `power` to its square roots after multiplication.
AULA_MULTIVERSION
void to_amplitude(Values& power, float factor) {
    for (float& x : power) x = std::sqrt(factor * x);
}

// Where the spectrum is steep, a third octave has more energy than its carrier: the crossovers add
// that of the louder neighbour. With the energies a and b of the neighbours re its own it is lower
// by 1 + kNeighbours (a + b - 2). T20 of third octaves is then that of a field whose decay changes
// continuously with frequency within 1 %, up to 26 dB per octave; without it up to 7 % longer.
constexpr float kNeighbours = 0.08F;

AULA_MULTIVERSION
void take_from_neighbours(const Values& energy, Values& taken) {
    taken = energy;
    for (std::size_t k = 1; k + 1 < energy.size(); ++k) {
        const float excess = energy[k - 1] + energy[k + 1] - 2 * energy[k];
        // Without energy the quotient may be 0 / 0: the smallest numbers are rounded to 0.
        if (excess > 0 && energy[k] > 0)
            taken[k] = energy[k] * (energy[k] / (energy[k] + kNeighbours * excess));
    }
}

/// The amplitude at the edge of two bins: the geometric mean of theirs (exact for an exponential
/// decay), but at most sqrt(3) times the lower one.
AULA_MULTIVERSION
void join(const Values& before, const Values& after, Values& edge) {
    for (std::size_t k = 0; k < edge.size(); ++k) {
        edge[k] = std::min(std::sqrt(before[k] * after[k]),
                           std::sqrt(3.0F) * std::min(before[k], after[k]));
    }
}

// With a^2 the mean power of the bin, e0 and e1 the amplitudes at its edges and c that at its
// centre, the energy of the bin is preserved if
//     [(e0^2 + e0 c + c^2) + (c^2 + c e1 + e1^2)] / 6 = a^2, that is
//     c = (sqrt(s^2 + 8 (6 a^2 - q)) - s) / 4,   s = e0 + e1, q = e0^2 + e1^2.
// For edges of at most sqrt(3) a, q <= 6 a^2 and c is real.
AULA_MULTIVERSION
void centre(const Values& begin, const Values& mean, const Values& end, Values& middle) {
    for (std::size_t k = 0; k < middle.size(); ++k) {
        const float s = begin[k] + end[k];
        const float q = begin[k] * begin[k] + end[k] * end[k];
        const float rest = std::max(6 * mean[k] * mean[k] - q, 0.0F);
        middle[k] = (std::sqrt(s * s + 8 * rest) - s) / 4;
    }
}

}  // namespace

std::vector<TailSegment> tail_envelope(const EnergyResponse& energy, const ThirdOctaveModel& model,
                                       double sample_rate_hz) {
    const TimeBins& bins = energy.bins;
    const std::vector<Bands> spread = spread_in_time(energy);
    std::vector<TailSegment> segments(2 * bins.count());
    Values before{};  // silence
    DirectionMoments directions_before;
    float energy_before = 0;
    DirectionMoments mean;
    for (std::size_t i = 0; i <= bins.count(); ++i) {
        const bool is_inside = i < bins.count();
        Values amplitude{};
        const DirectionMoments directions = is_inside ? energy.directions[i] : DirectionMoments{};
        const float sum = is_inside ? energy.energy[i].sum() : 0;
        const double begin_s = is_inside ? bins.begin_s(i) : bins.length_s();
        if (is_inside && spread[i].max() > 0) {
            const double centre_s = 0.5 * (begin_s + bins.end_s(i));
            best_version<take_from_neighbours>(
                model.at_centres(spread[i], centre_s * double{energy.speed_of_sound_m_s}),
                amplitude);
            // The squared pressure is spread over the bin's samples.
            const double samples = (bins.end_s(i) - begin_s) * sample_rate_hz;
            best_version<to_amplitude>(amplitude,
                                       static_cast<float>(squared_pressure(1.0) / samples));
        }
        Values edge;
        best_version<join>(before, amplitude, edge);
        // Spread energy keeps its directions.
        if (sum + energy_before > 0)
            mean = (directions_before + directions) / (energy_before + sum);
        if (i > 0) {
            TailSegment& rise = segments[2 * i - 2];
            TailSegment& fall = segments[2 * i - 1];
            best_version<centre>(rise.begin, before, edge, rise.end);
            fall.begin = rise.end;
            fall.end = edge;
            fall.directions_end = mean;
        }
        if (!is_inside) break;
        const double centre_s = 0.5 * (begin_s + bins.end_s(i));
        TailSegment& rise = segments[2 * i];
        TailSegment& fall = segments[2 * i + 1];
        rise.begin_s = begin_s;
        rise.end_s = fall.begin_s = centre_s;
        fall.end_s = bins.end_s(i);
        rise.begin = edge;
        rise.directions = mean;
        if (sum > 0) mean = directions / sum;
        rise.directions_end = fall.directions = mean;
        before = amplitude;
        directions_before = directions;
        energy_before = sum;
    }
    for (TailSegment& s : segments)
        s.loudest = std::max(*std::max_element(s.begin.begin(), s.begin.end()),
                             *std::max_element(s.end.begin(), s.end.end()));
    return segments;
}

}  // namespace aula
