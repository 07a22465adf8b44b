#pragma once

#include <cstddef>
#include <vector>

#include "apps/bench/base/settings.h"
#include "apps/bench/base/table.h"

namespace aula::bench {

/// What to measure of the convolution.
struct ConvolutionSweep {
    std::vector<double> responses_s{1, 2, 4};
    std::vector<std::size_t> blocks{64, 128, 256, 512};
    int rounds = 9;  ///< of which the best one's mean counts, and a block's median
};

/// What a block costs in CPU time: Aula's convolver in single precision and with a tail in half
/// precision, with and without exchange of filters, against the peers that were found when building
/// and against merely reading as much memory as it reads.
std::vector<Row> measure_convolution(const Settings& settings, const ConvolutionSweep& sweep);
const std::vector<Column>& convolution_columns();

/// What it costs to prepare filters, if all, a fifth or nothing of them has changed, against their
/// transforms alone.
std::vector<Row> measure_preparing(const Settings& settings, const ConvolutionSweep& sweep);
const std::vector<Column>& preparing_columns();

}  // namespace aula::bench
