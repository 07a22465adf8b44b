#pragma once

#include <functional>
#include <string>
#include <vector>

#include "apps/bench/convolution/convolution_case.h"

namespace aula::bench {

/// Another convolver.
struct ConvolutionPeer {
    std::string name;
    bool uses_threads = false;  ///< of its own, whose time counts, too

    /// Takes the filters; what it returns convolves a block of the signals. Throws Error where the
    /// library refuses.
    std::function<std::function<void()>(const ConvolutionCase& c, const ConvolutionFilters& filters,
                                        const ConvolutionSignals& signals)>
        start;
};

/// The textbook's uniform partitions over each FFT library, and zita-convolver with uniform and
/// with its own partitions, as far as they were found when building.
std::vector<ConvolutionPeer> convolution_peers();

}  // namespace aula::bench
