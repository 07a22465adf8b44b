#include "aula/audio/convolver.h"

#include <algorithm>
#include <cassert>
#include <vector>

#include "audio/convolution/convolver_levels.h"

namespace aula {

// At the start of a segment a level takes what the first level uses at that sample: a filter from
// its exchange to the end of the next one's fade, or from the middle of one fade to that of the
// next, within the rounding of the middle to a sample.
std::vector<char> levels_in_use(const ConvolutionShape& shape, std::size_t fade_samples,
                                std::int64_t first, std::int64_t next) {
    const std::vector<PartitionLevel> levels = partition_levels(shape);
    const auto fade = static_cast<std::int64_t>(fade_samples);
    std::vector<char> used(levels.size(), 1);
    if (first == 0 || next - first < fade) return used;
    for (std::size_t l = 1; l < levels.size(); ++l) {
        const auto size = static_cast<std::int64_t>(levels[l].size);
        const auto lead = static_cast<std::int64_t>(lead_samples(shape, l));
        const std::int64_t from = levels[l].blends() ? first : first + fade / 2 - 1;
        const std::int64_t to = levels[l].blends() ? next + fade : next + fade / 2 + 1;
        // Segments start at multiples of the size less the lead.
        const std::int64_t start = (from + lead + size - 1) / size * size - lead;
        used[l] = start < to ? 1 : 0;
    }
    return used;
}

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

std::size_t Convolver::max_filters() const noexcept {
    std::size_t filters = 2;
    for (const TailLevel& tail : state_->tails) filters += tail.max_filters();
    return filters;
}

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

// A tail level may take the filters of the first level later.
void Convolver::release_unused(const ConvolutionFilter* filter) const noexcept {
    const State& s = *state_;
    if (s.head.uses(filter)) return;
    filter->release(0);
    for (std::size_t l = 0; l < s.tails.size(); ++l)
        if (!s.tails[l].uses(filter)) filter->release(1 + l);
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
        const FilterBlend blend = s.head.blend();
        s.head.process(inputs, outputs, done, part);
        for (TailLevel& tail : s.tails) tail.process(inputs, outputs, done, part, blend);
        done += part;
    }
}

}  // namespace aula
