#pragma once

#include <cstddef>
#include <vector>

#include "audio/convolution/convolver.h"
#include "tests/audio/convolution/signals.h"

namespace aula::test {

using Responses = std::vector<Signals>;                 // [input][output]
using ExactSignals = std::vector<std::vector<double>>;  // [output][sample]

/// Unrelated responses for each input and output, of unit energy each.
Responses random_responses(const ConvolutionShape& shape, std::size_t taps, unsigned seed);

/// The taps first to end - 1 of responses, zeros in place of the others.
Responses part_of(const Responses& responses, std::size_t first, std::size_t end);

void fill(FilterTransform& transform, const Responses& responses, ConvolutionFilter& filter);
ConvolutionFilter make_filter(const ConvolutionShape& shape, const Responses& responses);

/// The convolution as it is defined, in double precision.
ExactSignals direct(const Signals& inputs, const Responses& responses);

/// Calls the convolver from sample `first` to `last`, with calls of the given sizes in turn.
void run(Convolver& convolver, const Signals& inputs, Signals& outputs, std::size_t first,
         std::size_t last, const std::vector<std::size_t>& calls);

double worst_error(const Signals& outputs, const ExactSignals& expected);

/// What a convolver is to do when filters are exchanged: how much each filter weighs in the output
/// of each level. The head fades from the exchange on. A tail takes the newest filter that the head
/// is done with at the start of a frame, and fades over the frame after that. The frames of level l
/// start 2^(l - 1) partitions of the head before the multiples of their size.
class ExchangePlan {
 public:
    /// Filter k is given at sample exchanges[k], the first at 0, before the first sample.
    ExchangePlan(const std::vector<PartitionLevel>& levels, std::size_t fade_samples,
                 const std::vector<std::size_t>& exchanges);

    double weight(std::size_t level, std::size_t filter, std::size_t sample) const;

 private:
    struct Fade {
        std::size_t start;
        std::size_t samples;
        std::size_t from;
        std::size_t to;
    };
    std::vector<std::vector<Fade>> fades_;  // [level]
};

}  // namespace aula::test
