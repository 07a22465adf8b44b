#include "tests/audio/convolution/convolution.h"

#include <algorithm>
#include <cmath>
#include <span>

namespace aula::test {

Responses random_responses(const ConvolutionShape& shape, std::size_t taps, unsigned seed) {
    Responses responses;
    for (std::size_t i = 0; i < shape.inputs; ++i) {
        responses.push_back(random_signals(shape.outputs, taps, seed + static_cast<unsigned>(i)));
        for (Signal& response : responses.back()) {
            for (float& x : response) x /= std::sqrt(static_cast<float>(taps));
        }
    }
    return responses;
}

Responses part_of(const Responses& responses, std::size_t first, std::size_t end) {
    Responses part = responses;
    for (Signals& signals : part) {
        for (Signal& signal : signals) {
            for (std::size_t n = 0; n < signal.size(); ++n) {
                if (n < first || n >= end) signal[n] = 0;
            }
        }
    }
    return part;
}

void fill(FilterTransform& transform, const Responses& responses, ConvolutionFilter& filter) {
    for (std::size_t i = 0; i < responses.size(); ++i) {
        const std::vector<std::span<const float>> views(responses[i].begin(), responses[i].end());
        transform.transform(views, i, filter);
    }
}

ConvolutionFilter make_filter(const ConvolutionShape& shape, const Responses& responses) {
    FilterTransform transform(shape);
    ConvolutionFilter filter(shape);
    fill(transform, responses, filter);
    return filter;
}

ExactSignals direct(const Signals& inputs, const Responses& responses) {
    const std::size_t samples = inputs[0].size();
    ExactSignals outputs(responses[0].size(), std::vector<double>(samples));
    for (std::size_t i = 0; i < inputs.size(); ++i) {
        const std::vector<double> x(inputs[i].begin(), inputs[i].end());
        for (std::size_t o = 0; o < outputs.size(); ++o) {
            const Signal& h = responses[i][o];
            for (std::size_t k = 0; k < std::min(h.size(), samples); ++k) {
                const double tap = h[k];
                if (tap == 0) continue;
                for (std::size_t n = k; n < samples; ++n) outputs[o][n] += tap * x[n - k];
            }
        }
    }
    return outputs;
}

void run(Convolver& convolver, const Signals& inputs, Signals& outputs, std::size_t first,
         std::size_t last, const std::vector<std::size_t>& calls) {
    std::vector<const float*> in(inputs.size());
    std::vector<float*> out(outputs.size());
    for (std::size_t turn = 0; first < last; ++turn) {
        const std::size_t samples = std::min(calls[turn % calls.size()], last - first);
        for (std::size_t i = 0; i < in.size(); ++i) in[i] = inputs[i].data() + first;
        for (std::size_t o = 0; o < out.size(); ++o) out[o] = outputs[o].data() + first;
        convolver.process(in, out, samples);
        first += samples;
    }
}

double worst_error(const Signals& outputs, const ExactSignals& expected) {
    double worst = 0;
    for (std::size_t o = 0; o < outputs.size(); ++o) {
        for (std::size_t n = 0; n < outputs[o].size(); ++n) {
            worst = std::max(worst, std::abs(double{outputs[o][n]} - expected[o][n]));
        }
    }
    return worst;
}

ExchangePlan::ExchangePlan(const std::vector<PartitionLevel>& levels, std::size_t fade_samples,
                           const std::vector<std::size_t>& exchanges)
    : levels_(levels), fade_samples_(fade_samples), exchanges_(exchanges) {}

namespace {

/// The weight at a sample of a fade: a line whose corners are parabolas over a fiftieth of it.
double faded(std::size_t at, std::size_t samples) {
    if (at >= samples) return 1;
    const double x = (static_cast<double>(at) + 0.5) / static_cast<double>(samples);
    const double near = std::min(x, 1 - x);
    const double part = (near < 0.02 ? near * near / 0.04 : near - 0.01) / 0.98;
    return x < 0.5 ? part : 1 - part;
}

}  // namespace

double ExchangePlan::head_weight(std::size_t filter, std::size_t sample) const {
    std::size_t newest = 0;
    while (newest + 1 < exchanges_.size() && exchanges_[newest + 1] <= sample) ++newest;
    const double w = newest == 0 ? 1 : faded(sample - exchanges_[newest], fade_samples_);
    return (filter == newest ? w : 0) + (filter + 1 == newest ? 1 - w : 0);
}

double ExchangePlan::weight(std::size_t level, std::size_t filter, std::size_t sample) const {
    if (levels_[level].first_tap == 0) return head_weight(filter, sample);
    const std::size_t size = levels_[level].size;
    const std::size_t lead = levels_[0].size << (level - 1);
    // The start of the present segment, and of those before it, in which the output was computed.
    const std::size_t segment = (sample + lead) / size;
    const auto taken = [&](std::size_t before) {
        if (segment <= before) return filter == 0 ? 1.0 : 0.0;
        const double w = head_weight(filter, (segment - before) * size - lead);
        if (levels_[level].blends()) return w;
        return w >= 0.5 ? 1.0 : 0.0;
    };
    const double w = faded(sample + lead - segment * size, size);
    return (1 - w) * taken(2) + w * taken(1);
}

}  // namespace aula::test
