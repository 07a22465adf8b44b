#pragma once

#include <filesystem>
#include <vector>

#include "apps/bench/base/settings.h"
#include "apps/bench/base/table.h"

namespace aula::bench {

/// How much an estimator's response differs from one restart to the next: rows for equal rays
/// (basis "rays"), then with the rays of each so many that a frame costs the CPU time of `patch` at
/// the scene's rays (basis "cpu").
std::vector<Row> measure_noise(const Subject& subject, const Settings& settings);

const std::vector<Column>& noise_columns();

/// Noise, bias, size and cost of the estimators over a range of tau, and of lambda, the other as
/// the scene has it; at equal rays.
struct Sweep {
    std::vector<Row> by_tau;
    std::vector<Row> by_patch_size;
};

Sweep measure_sweep(const Subject& subject, const Settings& settings);

const std::vector<Column>& sweep_columns();

/// Draws a sweep into sweep_tau_NAME.svg and sweep_lambda_NAME.svg of an existing folder, NAME the
/// scene's. Throws Error if they cannot be written.
void write_plots(const Sweep& sweep, const std::filesystem::path& folder);

}  // namespace aula::bench
