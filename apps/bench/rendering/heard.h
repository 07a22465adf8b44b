#pragma once

#include <vector>

#include "apps/bench/base/settings.h"
#include "apps/bench/base/table.h"

namespace aula::bench {

/// What is heard of the first source at the listener, against theory. Of the impulse response: its
/// normalised echo density (Abel and Huang 2006; 1: Gaussian noise) at 5, 20, 50 and 100 ms after
/// the first arrival. Of its reverberation without discrete paths: the kurtosis of octaves, 3 in
/// Gaussian noise; the standard deviation of the level over frequency, 5.57 dB in a diffuse field;
/// the largest error of T20 in a third octave from 250 Hz to 16 kHz re third_octave_parameters(),
/// of the mean decay of 100 independent noises, with its standard deviation by theory; the
/// correlation at 0.1 and 1 m in the octave of 500 Hz with that of a diffuse field, sin(kd) / (kd);
/// the standard deviation of the level of a tone of 1 kHz among 48 places, 5.57 dB in a diffuse
/// field.
std::vector<Row> measure_heard(const Subject& subject, const Settings& settings);
const std::vector<Column>& heard_columns();

}  // namespace aula::bench
