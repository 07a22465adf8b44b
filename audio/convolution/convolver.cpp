#include "aula/audio/convolver.h"

#include <algorithm>
#include <cassert>
#include <vector>

#include "audio/convolution/convolver_levels.h"

namespace aula {

struct Convolver::State {
    State(const ConvolutionShape& shape_in, std::size_t fade_samples)
        : shape(shape_in), head(shape_in, partition_levels(shape_in)[0], fade_samples) {
        const std::vector<PartitionLevel> levels = partition_levels(shape);
        assert(levels.size() <= kMaxLevels);
        for (std::size_t l = 1; l < levels.size(); ++l) tails.emplace_back(shape, levels[l], l);
    }

    ConvolutionShape shape;
    HeadLevel head;
    std::vector<TailLevel> tails;
    bool started = false;
};

Convolver::Convolver(const ConvolutionShape& shape, std::size_t fade_samples)
    : state_(std::make_unique<State>(shape, fade_samples)) {}
Convolver::~Convolver() = default;
Convolver::Convolver(Convolver&&) noexcept = default;
Convolver& Convolver::operator=(Convolver&&) noexcept = default;

bool Convolver::fading() const noexcept { return state_->head.fading(); }

std::size_t Convolver::max_filters() const noexcept { return 2 * (1 + state_->tails.size()); }

void Convolver::exchange(const ConvolutionFilter* filter) noexcept {
    assert(filter != nullptr);
    State& s = *state_;
    if (s.started) {
        s.head.exchange(filter);
        return;
    }
    s.head.start_with(filter);
    for (TailLevel& tail : s.tails) tail.start_with(filter);
}

bool Convolver::uses(const ConvolutionFilter* filter) const noexcept {
    const State& s = *state_;
    return s.head.uses(filter) || std::any_of(s.tails.begin(), s.tails.end(),
                                              [&](const auto& tail) { return tail.uses(filter); });
}

void Convolver::process(std::span<const float* const> inputs, std::span<float* const> outputs,
                        std::size_t samples) noexcept {
    State& s = *state_;
    assert(inputs.size() == s.shape.inputs && outputs.size() == s.shape.outputs);
    assert(samples <= s.shape.block);
    if (samples > 0) s.started = true;
    for (std::size_t done = 0; done < samples;) {
        // Segments of all levels end where partitions of the first level end.
        const std::size_t part = std::min(samples - done, s.head.room());
        const ConvolutionFilter* const filter = s.head.current();
        s.head.process(inputs, outputs, done, part);
        for (TailLevel& tail : s.tails) tail.process(inputs, outputs, done, part, filter);
        done += part;
    }
}

}  // namespace aula
