#pragma once

#include <vector>

#include "apps/bench/base/settings.h"
#include "apps/bench/base/table.h"

namespace aula::bench {

/// Error of an estimator's response while the listener, the source or both move: rows at equal
/// rays, then at equal CPU time as in measure_noise. An end without a path uses the other's; if
/// both use the same path, the source follows it backwards. Throws InputError if the scene has no
/// path.
std::vector<Row> measure_tracking(const Subject& subject, const Settings& settings);

const std::vector<Column>& tracking_columns();

}  // namespace aula::bench
