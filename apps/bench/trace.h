#pragma once

#include <vector>

#include "apps/bench/settings.h"
#include "apps/bench/table.h"

namespace aula::bench {

/// Ray segments that the engine gets through in whole frames, caches, gathering and image sources
/// included, against Embree alone: the same rays through rtcIntersect1 on as many threads, frame by
/// frame in turn. A row an estimator.
std::vector<Row> measure_tracing(const Subject& subject, const Settings& settings);

const std::vector<Column>& tracing_columns();

}  // namespace aula::bench
