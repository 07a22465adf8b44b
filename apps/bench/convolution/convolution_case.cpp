#include "apps/bench/convolution/convolution_case.h"

#include <algorithm>
#include <cmath>

#include "engine/base/sampling.h"

namespace aula::bench {

ConvolutionSignals::ConvolutionSignals(const ConvolutionCase& c, std::uint64_t seed)
    : input_samples(c.sources, AlignedVector<float>(c.block)),
      output_samples(c.channels, AlignedVector<float>(c.block)) {
    RandomStream random(seed);
    for (AlignedVector<float>& samples : input_samples) {
        std::generate(samples.begin(), samples.end(), [&] { return 2 * random.uniform() - 1; });
        inputs.push_back(samples.data());
    }
    for (AlignedVector<float>& samples : output_samples) outputs.push_back(samples.data());
}

ConvolutionFilters decaying_noise(const ConvolutionCase& c, std::uint64_t seed) {
    RandomStream random(seed);
    const std::size_t taps = c.taps();
    const auto decay = static_cast<float>(std::exp(-6.9 / static_cast<double>(taps)));
    ConvolutionFilters filters(c.sources);
    for (auto& channels : filters) {
        channels.assign(c.channels, std::vector<float>(taps));
        for (std::vector<float>& response : channels) {
            float size = 0.02F;
            for (float& x : response) {
                x = size * (random.uniform() - 0.5F);
                size *= decay;
            }
        }
    }
    return filters;
}

}  // namespace aula::bench
