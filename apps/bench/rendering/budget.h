#pragma once

#include <vector>

#include "apps/bench/base/settings.h"
#include "apps/bench/base/table.h"

namespace aula::bench {

/// The cost of offline rendering of a scene, with all its sources in each quality, and in normal
/// quality with 1, 4 and 16 sources like the first one, at rest and moving: rays of the last frame,
/// CPU time of a second of sound, and the counted over the measured time of the propagation
/// (counted_s()).
std::vector<Row> measure_budget(const Subject& subject, const Settings& settings);
const std::vector<Column>& budget_columns();

}  // namespace aula::bench
