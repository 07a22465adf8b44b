#pragma once

#include <memory>

#include "apps/room/frames/signals.h"

namespace aula {

/// Signals that a source can play in place of the scene's. Peaks are at most -6 dBFS.
enum class TestSignal { clap, noise_burst, noise, clicks };

const char* test_signal_name(TestSignal signal);

/// Clap: decaying noise of 40 ms, every 1.5 s. Noise burst: 0.25 s of noise, every 1.5 s. Noise:
/// continuous. Clicks: one sample of amplitude 0.5, every 0.5 s.
std::shared_ptr<const Signal> test_signal(TestSignal signal, double sample_rate_hz);

}  // namespace aula
