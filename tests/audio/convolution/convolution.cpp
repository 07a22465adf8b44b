#include "tests/audio/convolution/convolution.h"

#include <algorithm>
#include <cmath>
#include <numbers>
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
                           const std::vector<std::size_t>& exchanges) {
    for (std::size_t l = 0; l < levels.size(); ++l) {
        const PartitionLevel& level = levels[l];
        std::vector<Fade> fades{{0, 0, 0, 0}};
        if (level.first_tap == 0) {
            for (std::size_t k = 1; k < exchanges.size(); ++k) {
                fades.push_back({exchanges[k], fade_samples, k - 1, k});
            }
        } else {
            const std::size_t last = exchanges.back() + fade_samples + level.size;
            const std::size_t first = level.size - (levels[0].size << (l - 1));
            std::size_t newest = 0;
            for (std::size_t start = first; start <= last; start += level.size) {
                const std::size_t before = newest;
                while (newest + 1 < exchanges.size() &&
                       exchanges[newest + 1] + fade_samples <= start)
                    ++newest;
                if (newest == before) continue;
                fades.push_back({start + level.size, level.size, before, newest});
            }
        }
        fades_.push_back(fades);
    }
}

double ExchangePlan::weight(std::size_t level, std::size_t filter, std::size_t sample) const {
    const auto fade = std::find_if(fades_[level].rbegin(), fades_[level].rend(),
                                   [&](const Fade& f) { return f.start <= sample; });
    double w = 1;
    if (sample < fade->start + fade->samples) {
        const double position =
            (static_cast<double>(sample - fade->start) + 0.5) / static_cast<double>(fade->samples);
        w = 0.5 - 0.5 * std::cos(std::numbers::pi * position);
    }
    return (filter == fade->to ? w : 0) + (filter == fade->from ? 1 - w : 0);
}

}  // namespace aula::test
