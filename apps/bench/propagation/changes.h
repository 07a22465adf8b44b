#pragma once

#include <vector>

#include "apps/bench/base/settings.h"
#include "apps/bench/base/table.h"

namespace aula::bench {

/// CPU time of the frames of `patch` around a change: the source, the listener or both rest, walk
/// or jump, and rest again; or the objects of the scene move on their paths. One row per change,
/// with the mean and the most expensive frame. The sequence of frames of a change is computed
/// several times; the time of a frame is the least of them, which other load increases least.
std::vector<Row> measure_changes(const Subject& subject, const Settings& settings);

const std::vector<Column>& changes_columns();

}  // namespace aula::bench
