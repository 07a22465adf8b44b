#pragma once

#include <vector>

#include "apps/bench/settings.h"
#include "apps/bench/table.h"

namespace aula::bench {

/// How much an estimator's response differs from one restart to the next: rows for equal rays
/// (basis "rays"), then with the rays of each so many that a frame costs the CPU time of `patch` at
/// the scene's rays (basis "cpu").
std::vector<Row> measure_noise(const Subject& subject, const Settings& settings);

const std::vector<Column>& noise_columns();

}  // namespace aula::bench
