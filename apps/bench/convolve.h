#pragma once

#include <vector>

#include "apps/bench/settings.h"
#include "apps/bench/table.h"

namespace aula::bench {

/// What a block of the audio thread costs: Aula's convolver, with and without exchange of filters,
/// against a textbook's uniform convolver and, where it was found when building, zita-convolver.
/// `blocks` are timed of each.
std::vector<Row> measure_convolution(const Settings& settings, int blocks);

const std::vector<Column>& convolution_columns();

}  // namespace aula::bench
