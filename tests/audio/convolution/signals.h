#pragma once

#include <cstddef>
#include <vector>

namespace aula::test {

using Signal = std::vector<float>;
using Signals = std::vector<Signal>;

/// Independent normal deviates of unit variance.
Signals random_signals(std::size_t count, std::size_t samples, unsigned seed);

Signal sine(double frequency_hz, std::size_t samples, double sample_rate_hz);

/// Energy of the spectrum farther than `distance_hz` from `centre_hz`, in dB re the total. The
/// signal is windowed; side lobes are below -90 dB.
double energy_outside_db(const Signal& signal, double centre_hz, double distance_hz,
                         double sample_rate_hz);

/// The peak of the windowed signal without the spectrum nearer than `distance_hz` to `centre_hz`,
/// in dB re the peak of the whole windowed signal.
double peak_outside_db(const Signal& signal, double centre_hz, double distance_hz,
                       double sample_rate_hz);

/// Energy between two frequencies.
double band_energy(const Signal& signal, double from_hz, double to_hz, double sample_rate_hz);

}  // namespace aula::test
