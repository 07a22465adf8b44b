#include "apps/bench/convolve.h"

#include <time.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <string>

#include "apps/bench/uniform_convolver.h"
#ifdef AULA_BENCH_ZITA
#include "apps/bench/zita_convolver.h"
#endif
#include "audio/convolver.h"
#include "audio/realtime.h"
#include "engine/sampling.h"

namespace aula::bench {

namespace {

constexpr double kRate_hz = 48000;
constexpr std::size_t kBlock = 128;
constexpr double kResponse_s = 2;
constexpr double kExchange_hz = 30;
constexpr double kFade_s = 0.02;

struct Case {
    std::size_t sources;
    std::size_t channels;
};
constexpr std::array<Case, 3> kCases{{{1, 2}, {8, 2}, {1, 16}}};

/// Signals and filters of a case: decaying noise.
struct Material {
    std::vector<std::vector<float>> inputs;                  // [source], one block
    std::vector<std::vector<float>> outputs;                 // [channel]
    std::vector<std::vector<std::vector<float>>> responses;  // [source][channel]
    std::vector<const float*> input_pointers;
    std::vector<float*> output_pointers;

    Material(const Case& c, std::uint64_t seed) {
        RandomStream random(seed);
        const auto noise = [&] { return 2 * random.uniform() - 1; };
        const auto taps = static_cast<std::size_t>(kResponse_s * kRate_hz);
        for (std::size_t s = 0; s < c.sources; ++s) {
            inputs.emplace_back(kBlock);
            std::generate(inputs.back().begin(), inputs.back().end(), noise);
            responses.emplace_back(c.channels, std::vector<float>(taps));
            for (std::vector<float>& response : responses.back()) {
                for (std::size_t n = 0; n < taps; ++n) {
                    // 60 dB over its length.
                    const double decay =
                        std::exp(-6.9 * static_cast<double>(n) / static_cast<double>(taps));
                    response[n] = 0.01F * noise() * static_cast<float>(decay);
                }
            }
        }
        outputs.assign(c.channels, std::vector<float>(kBlock));
        for (const auto& input : inputs) input_pointers.push_back(input.data());
        for (auto& output : outputs) output_pointers.push_back(output.data());
    }
};

struct Cost {
    double mean_us = 0;
    double worst_us = 0;
};

/// CPU time of this thread in us: blocks are far shorter than the slices of time in which a busy
/// machine takes the processor away.
double thread_time_us() {
    timespec now{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) * 1e6 + static_cast<double>(now.tv_nsec) * 1e-3;
}

/// Times `block(i)` after one response's length of warming up.
Cost time_blocks(int blocks, const std::function<void(int)>& block) {
    const int warm_up = static_cast<int>(kResponse_s * kRate_hz / static_cast<double>(kBlock));
    Cost cost;
    for (int i = -warm_up; i < blocks; ++i) {
        const double began_us = thread_time_us();
        block(i);
        const double spent_us = thread_time_us() - began_us;
        if (i < 0) continue;
        cost.mean_us += spent_us / blocks;
        cost.worst_us = std::max(cost.worst_us, spent_us);
    }
    return cost;
}

Cost time_aula(const Case& c, Material& material, double exchange_hz, int blocks) {
    const ConvolutionShape shape{c.sources, c.channels, kBlock, material.responses[0][0].size()};
    FilterTransform transform(shape);
    std::array<ConvolutionFilter, 2> filters{ConvolutionFilter(shape), ConvolutionFilter(shape)};
    for (ConvolutionFilter& filter : filters) {
        for (std::size_t s = 0; s < c.sources; ++s) {
            std::vector<std::span<const float>> responses(material.responses[s].begin(),
                                                          material.responses[s].end());
            transform.transform(responses, s, filter);
        }
    }
    Convolver convolver(shape, static_cast<std::size_t>(kFade_s * kRate_hz));
    convolver.exchange(&filters[0]);
    double next_exchange = exchange_hz > 0 ? 0 : blocks;
    std::size_t present = 0;
    return time_blocks(blocks, [&](int i) {
        if (i >= next_exchange && !convolver.fading()) {
            present = 1 - present;
            convolver.exchange(&filters[present]);
            next_exchange += kRate_hz / static_cast<double>(kBlock) / exchange_hz;
        }
        convolver.process(material.input_pointers, material.output_pointers, kBlock);
    });
}

Cost time_textbook(const Case& c, Material& material, int blocks) {
    UniformConvolver convolver(c.sources, c.channels, kBlock, material.responses[0][0].size());
    for (std::size_t s = 0; s < c.sources; ++s) {
        for (std::size_t o = 0; o < c.channels; ++o) {
            convolver.set_filter(s, o, material.responses[s][o]);
        }
    }
    return time_blocks(
        blocks, [&](int) { convolver.process(material.input_pointers, material.output_pointers); });
}

#ifdef AULA_BENCH_ZITA
Cost time_zita(const Case& c, Material& material, int blocks) {
    ZitaConvolver convolver(c.sources, c.channels, kBlock, material.responses[0][0].size());
    for (std::size_t s = 0; s < c.sources; ++s) {
        for (std::size_t o = 0; o < c.channels; ++o) {
            convolver.set_filter(s, o, material.responses[s][o]);
        }
    }
    convolver.start();
    return time_blocks(
        blocks, [&](int) { convolver.process(material.input_pointers, material.output_pointers); });
}
#endif

}  // namespace

std::vector<Row> measure_convolution(const Settings& settings, int blocks) {
    const FlushDenormals flush;
    std::vector<Row> rows;
    for (const Case& c : kCases) {
        Material material(c, settings.seed.value_or(1));
        double aula_mean_us = 0;
        const auto add = [&](const char* library, double exchange_hz, const Cost& cost) {
            const bool own = std::string(library) == "aula";
            if (own && exchange_hz == 0) aula_mean_us = cost.mean_us;
            Row row;
            row.figures = {{"bench", "convolve"},
                           {"scene", Value{}},
                           {"basis", "cpu"},
                           {"library", library},
                           {"sources", static_cast<std::int64_t>(c.sources)},
                           {"channels", static_cast<std::int64_t>(c.channels)},
                           {"ir_s", kResponse_s},
                           {"block", static_cast<std::int64_t>(kBlock)},
                           {"exchange_hz", exchange_hz},
                           {"mean_us", cost.mean_us},
                           {"worst_us", cost.worst_us},
                           {"ratio", own ? 1.0 : aula_mean_us / cost.mean_us}};
            rows.push_back(row);
        };
        settings.progress("convolve: " + std::to_string(c.sources) + " x " +
                          std::to_string(c.channels));
        add("aula", 0, time_aula(c, material, 0, blocks));
        add("aula", kExchange_hz, time_aula(c, material, kExchange_hz, blocks));
        add("textbook", 0, time_textbook(c, material, blocks));
#ifdef AULA_BENCH_ZITA
        add("zita", 0, time_zita(c, material, blocks));
#endif
    }
    return rows;
}

const std::vector<Column>& convolution_columns() {
    static const std::vector<Column> columns{
        {"library", "library", 0}, {"sources", "sources", 0},   {"channels", "channels", 0},
        {"ir_s", "IR s", 1},       {"block", "block", 0},       {"exchange_hz", "exchange Hz", 0},
        {"mean_us", "mean us", 1}, {"worst_us", "worst us", 1}, {"ratio", "aula / it", 3}};
    return columns;
}

}  // namespace aula::bench
