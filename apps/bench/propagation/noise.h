#pragma once

#include <vector>

#include "apps/bench/base/settings.h"
#include "apps/bench/base/table.h"

namespace aula::bench {

/// Deviation of an estimator's response between restarts, and its bias. First rows at equal rays
/// (basis "rays"), then rows at equal CPU time (basis "cpu"): each estimator has the number of rays
/// whose frame costs as much as that of `patch` with the scene's rays.
std::vector<Row> measure_noise(const Subject& subject, const Settings& settings);

const std::vector<Column>& noise_columns();

/// Noise, bias, memory and cost of the estimators at equal rays: first over a range of tau, then
/// over a range of lambda. The other of the two is the scene's.
std::vector<Row> measure_sweep(const Subject& subject, const Settings& settings);

const std::vector<Column>& sweep_columns();

}  // namespace aula::bench
