#include "audio/convolution/convolver.h"

#include <algorithm>
#include <cassert>

namespace aula {

Convolver::Convolver(const ConvolutionShape& shape, std::size_t fade_samples)
    : shape_(shape), head_(shape, partition_levels(shape)[0], fade_samples) {
    const std::vector<PartitionLevel> levels = partition_levels(shape);
    assert(levels.size() <= kMostLevels);
    for (std::size_t l = 1; l < levels.size(); ++l) tails_.emplace_back(shape, levels[l], l);
}

void Convolver::exchange(const ConvolutionFilter* filter) noexcept {
    assert(filter != nullptr);
    if (started_) {
        head_.exchange(filter);
        return;
    }
    head_.start_with(filter);
    for (TailLevel& tail : tails_) tail.start_with(filter);
}

bool Convolver::uses(const ConvolutionFilter* filter) const noexcept {
    return head_.uses(filter) || std::any_of(tails_.begin(), tails_.end(),
                                             [&](const auto& tail) { return tail.uses(filter); });
}

void Convolver::process(std::span<const float* const> inputs, std::span<float* const> outputs,
                        std::size_t samples) noexcept {
    assert(inputs.size() == shape_.inputs && outputs.size() == shape_.outputs);
    assert(samples <= shape_.block);
    if (samples > 0) started_ = true;
    for (std::size_t done = 0; done < samples;) {
        // Segments of all levels end where partitions of the first level end.
        const std::size_t part = std::min(samples - done, head_.room());
        const ConvolutionFilter* const filter = head_.current();
        head_.process(inputs, outputs, done, part);
        for (TailLevel& tail : tails_) tail.process(inputs, outputs, done, part, filter);
        done += part;
    }
}

}  // namespace aula
