#pragma once

#include <vector>

#include "apps/bench/base/settings.h"
#include "apps/bench/base/table.h"

namespace aula::bench {

/// CPU time of a frame of `patch` with one source and with many, over the first seconds: with all
/// at rest, with the listener on its path, and with all sources walking, too. With a mover also the
/// tracking error at the end, over all sources. Sources are placed along random rays from the first
/// one. Throws InputError if the listener has no path.
std::vector<Row> measure_many_sources(const Subject& subject, const Settings& settings);

const std::vector<Column>& many_sources_columns();

}  // namespace aula::bench
