#pragma once

#include <vector>

#include "apps/bench/base/settings.h"
#include "apps/bench/base/table.h"

namespace aula::bench {

/// How far an estimator's response is from the truth while the listener, the source or both walk:
/// rows for equal rays, then for equal CPU time as in measure_noise. Who has no path of its own
/// walks the other's; where both walk one path, the source walks it backwards. Throws Error if the
/// scene has no path.
std::vector<Row> measure_tracking(const Subject& subject, const Settings& settings);

const std::vector<Column>& tracking_columns();

}  // namespace aula::bench
