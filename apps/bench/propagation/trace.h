#pragma once

#include <vector>

#include "apps/bench/base/settings.h"
#include "apps/bench/base/table.h"

namespace aula::bench {

/// Ray segments that the engine gets through in whole frames, caches, gathering and image sources
/// included, against Embree alone: the rays of every fourth frame through rtcIntersect1 on as many
/// threads. They take turns, for three frames that are timed after one that is not: a live scene's
/// frames follow each other, too. A row an estimator. Times are medians of frames: CPU time where
/// one thread works, so that other programs do not count; with more, time by the clock, and beside
/// it that of one thread for the same frame and the same rays. `response_ms` is the time that a
/// first-order impulse response takes one thread, `additions_per_cycle` how much of its core the
/// process had.
std::vector<Row> measure_tracing(const Subject& subject, const Settings& settings);

const std::vector<Column>& tracing_columns();

}  // namespace aula::bench
