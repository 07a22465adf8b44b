#pragma once

#include <cstddef>
#include <vector>

#include "audio/convolution/partition_levels.h"
#include "aula/audio/convolver.h"
#include "tests/audio/convolution/signals.h"

namespace aula::test {

using Responses = std::vector<Signals>;                 // [input][output]
using ExactSignals = std::vector<std::vector<double>>;  // [output][sample]

/// Independent random responses for each input and output, of unit energy each.
Responses random_responses(const ConvolutionShape& shape, std::size_t taps, unsigned seed);

/// The taps [first, end) of responses; all others are zero.
Responses part_of(const Responses& responses, std::size_t first, std::size_t end);

void fill(FilterTransform& transform, const Responses& responses, ConvolutionFilter& filter);
ConvolutionFilter make_filter(const ConvolutionShape& shape, const Responses& responses);

/// The convolution by its definition, in double precision.
ExactSignals direct(const Signals& inputs, const Responses& responses);

/// Convolves samples [first, last) in calls whose sizes cycle through `calls`.
void run(Convolver& convolver, const Signals& inputs, Signals& outputs, std::size_t first,
         std::size_t last, const std::vector<std::size_t>& calls);

double worst_error(const Signals& outputs, const ExactSignals& expected);

/// The expected weight of each filter in the output of each level when filters are exchanged. The
/// head fades from the exchange on. At the start of a segment a tail takes the weights of the head;
/// in the next segment it goes to them from those that it took before. The segments of level l
/// start 2^(l - 1) head partitions before the multiples of their size.
class ExchangePlan {
 public:
    /// Filter k is set at sample exchanges[k]; exchanges[0] is 0.
    ExchangePlan(const std::vector<PartitionLevel>& levels, std::size_t fade_samples,
                 const std::vector<std::size_t>& exchanges);

    double weight(std::size_t level, std::size_t filter, std::size_t sample) const;

 private:
    double head_weight(std::size_t filter, std::size_t sample) const;

    std::vector<PartitionLevel> levels_;
    std::size_t fade_samples_;
    std::vector<std::size_t> exchanges_;
};

}  // namespace aula::test
