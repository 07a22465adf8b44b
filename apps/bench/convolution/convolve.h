#pragma once

#include <cstddef>
#include <vector>

#include "apps/bench/base/settings.h"
#include "apps/bench/base/table.h"

namespace aula::bench {

/// Cases to measure.
struct ConvolutionSweep {
    std::vector<double> responses_s{1, 2, 4};
    std::vector<std::size_t> blocks{64, 128, 256, 512};
    int rounds = 9;  ///< of which the least mean and the median of each block count
};

/// CPU time of a block: the convolver in single precision and with a tail in half precision, with
/// and without exchange of filters; the peers found at build time; and the time to read as much
/// memory as the convolver reads.
std::vector<Row> measure_convolution(const Settings& settings, const ConvolutionSweep& sweep);
const std::vector<Column>& convolution_columns();

/// Time to prepare filters of which all, a fifth or nothing has changed, and the time of their
/// transforms alone.
std::vector<Row> measure_preparing(const Settings& settings, const ConvolutionSweep& sweep);
const std::vector<Column>& preparing_columns();

}  // namespace aula::bench
