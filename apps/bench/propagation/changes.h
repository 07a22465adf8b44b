#pragma once

#include <vector>

#include "apps/bench/base/settings.h"
#include "apps/bench/base/table.h"

namespace aula::bench {

/// CPU time of the frames of `patch` around a change: an end of the sound paths, or both, begins to
/// walk or jumps after a rest, and rests again; and while the objects of the scene move on their
/// paths. One row per change, with the mean and the most expensive frame. Each script is repeated,
/// and each frame counts with its least time, which other load increases least.
std::vector<Row> measure_changes(const Subject& subject, const Settings& settings);

const std::vector<Column>& changes_columns();

}  // namespace aula::bench
