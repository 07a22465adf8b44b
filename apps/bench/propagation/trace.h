#pragma once

#include <vector>

#include "apps/bench/base/settings.h"
#include "apps/bench/base/table.h"

namespace aula::bench {

/// Ray segments per second of whole frames (caches, gathering and image sources included) and of
/// Embree's rtcIntersect1 for the rays of every fourth frame, on the same number of threads. Both
/// are timed in turn, three frames after one that is not timed. One row per estimator. Times are
/// medians over frames: CPU time for one thread; for several threads wall-clock time, and that of
/// one thread for the same frames and rays. `response_ms` is one thread's time for an impulse
/// response of order 1.
std::vector<Row> measure_tracing(const Subject& subject, const Settings& settings);

const std::vector<Column>& tracing_columns();

}  // namespace aula::bench
