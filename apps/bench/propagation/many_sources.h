#pragma once

#include <vector>

#include "apps/bench/base/settings.h"
#include "apps/bench/base/table.h"

namespace aula::bench {

/// CPU time of a frame of `patch` with one source and with many, all at rest, over the first
/// seconds; first with the listener at rest, then on its path. For a moving listener also the
/// tracking error at the end, over all sources. Sources are placed along random rays from the first
/// one. Throws InputError if the listener has no path.
std::vector<Row> measure_many_sources(const Subject& subject, const Settings& settings);

const std::vector<Column>& many_sources_columns();

}  // namespace aula::bench
