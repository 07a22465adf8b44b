#pragma once

#include <functional>
#include <string>
#include <vector>

#include "apps/bench/convolution/convolution_case.h"

namespace aula::bench {

/// Another convolver.
struct ConvolutionPeer {
    std::string name;
    bool uses_threads = false;  ///< separate threads, whose CPU time counts

    /// Sets the filters and returns a function that convolves a block of the signals. Throws
    /// InputError if the library refuses.
    std::function<std::function<void()>(const ConvolutionCase& c, const ConvolutionFilters& filters,
                                        const ConvolutionSignals& signals)>
        start;
};

/// Uniform partitions over each FFT library, and zita-convolver with uniform and with its own
/// partitions, as far as they were found at build time.
std::vector<ConvolutionPeer> convolution_peers();

}  // namespace aula::bench
