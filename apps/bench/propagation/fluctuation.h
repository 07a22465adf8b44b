#pragma once

#include <vector>

#include "apps/bench/base/settings.h"
#include "apps/bench/base/table.h"

namespace aula::bench {

/// The fluctuation of what is heard during a walk: steady pink noise of the first source, rendered
/// at the scene's own settings and with kConvergedRays times the rays. The levels of both
/// renderings in windows of kWindow_s are compared, a row per octave. Throws InputError if nothing
/// walks.
std::vector<Row> measure_fluctuation(const Subject& subject, const Settings& settings);

/// Duration of a window in s.
inline constexpr double kWindow_s = 0.05;

/// Rays of the converged walk, relative to the scene's.
inline constexpr int kConvergedRays = 16;

/// Pink noise (-3 dB per octave from 20 Hz on), rms 0.1, which repeats after `samples` samples, an
/// even number. Deterministic.
std::vector<float> pink_noise(std::size_t samples, double rate_hz);

/// Energy of an octave of a signal in consecutive windows: [window]. `samples` as for pink_noise.
std::vector<double> octave_energy(const std::vector<float>& signal, double centre_hz,
                                  double rate_hz);

const std::vector<Column>& fluctuation_columns();

}  // namespace aula::bench
