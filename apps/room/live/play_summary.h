#pragma once

#include <string>

#include "apps/room/live/player.h"

namespace aula {

/// A line with duration, underruns, frames and load.
std::string play_summary(const PlayStatus& status);

/// A line with the latencies; "-" where nothing has been measured.
std::string latency_summary(const PoseLatency& latency);

}  // namespace aula
