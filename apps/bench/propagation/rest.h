#pragma once

#include <vector>

#include "apps/bench/base/settings.h"
#include "apps/bench/base/table.h"

namespace aula::bench {

/// The error of `patch` after 10 s in which source, listener and scene are at rest, with as many
/// rays as a frame of `settings.frame_ms` of CPU time allows: what is left is the bias and the
/// noise of all rays.
std::vector<Row> measure_rest(const Subject& subject, const Settings& settings);

const std::vector<Column>& rest_columns();

}  // namespace aula::bench
