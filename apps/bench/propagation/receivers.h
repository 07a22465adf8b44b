#pragma once

#include <vector>

#include "apps/bench/base/settings.h"
#include "apps/bench/base/table.h"

namespace aula::bench {

/// What an additional receiver of a measurement costs, relative to the rays of one source. In each
/// window of frames from empty caches, the rays are traced and kReceivers receivers gather. The row
/// has the medians over the windows, of wall-clock times with the same threads.
std::vector<Row> measure_receivers(const Subject& subject, const Settings& settings);

const std::vector<Column>& receivers_columns();

}  // namespace aula::bench
