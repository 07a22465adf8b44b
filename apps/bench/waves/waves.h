#pragma once

#include <vector>

#include "apps/bench/base/settings.h"
#include "apps/bench/base/table.h"

namespace aula::bench {

/// The modes of a scene's room at low frequencies: their number and cost, and the differences of
/// octave levels from a grid with half as many cells again along each axis. Without modes the row
/// says why.
std::vector<Row> measure_waves(const Subject& subject, const Settings& settings);

const std::vector<Column>& waves_columns();

}  // namespace aula::bench
