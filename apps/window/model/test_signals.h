#pragma once

#include <memory>

#include "apps/session/frames/signals.h"

namespace aula {

/// What a source can be given to play in place of its own signal; peaks are below -6 dBFS.
enum class TestSignal { clap, noise_burst, noise, clicks };

const char* test_signal_name(TestSignal signal);

/// A clap: some milliseconds of noise that die away, every 1.5 s. A noise burst: a quarter of a
/// second every 1.5 s. Noise: without end. Clicks: a unit impulse every half second.
std::shared_ptr<const Signal> test_signal(TestSignal signal, double sample_rate_hz);

}  // namespace aula
