#pragma once

#include <vector>

#include "apps/bench/base/settings.h"
#include "apps/bench/base/table.h"

namespace aula::bench {

/// What many sources cost beside one, with `patch`, while they stand and the listener stands or
/// walks: CPU time of a frame over the walk's first seconds. Where he walks, the tracking error at
/// its end beside it, over all sources. The sources stand where random rays from the first one get
/// to. Throws Error if the listener has no path.
std::vector<Row> measure_many_sources(const Subject& subject, const Settings& settings);

const std::vector<Column>& many_sources_columns();

}  // namespace aula::bench
