#include "apps/bench/convolution/convolve.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <memory>
#include <span>
#include <string>

#include "apps/bench/convolution/block_times.h"
#include "apps/bench/convolution/convolution_case.h"
#include "apps/bench/convolution/convolution_peers.h"
#include "audio/convolution/block_transform.h"
#include "audio/convolution/partition_levels.h"
#include "aula/audio/convolver.h"
#include "aula/audio/realtime.h"

namespace aula::bench {

namespace {

constexpr double kExchange_hz = 30;

// Filters exchanged in turn. A level that takes only every fifth or sixth of them gets different
// ones.
constexpr unsigned kFilters = 7;

struct Channels {
    std::size_t sources;
    std::size_t channels;
};
constexpr std::array<Channels, 4> kChannels{{{1, 2}, {8, 2}, {1, 4}, {1, 16}}};

ConvolutionShape shape_of(const ConvolutionCase& c, bool half_precision) {
    return {c.sources, c.channels, c.block, c.taps(), half_precision};
}

void fill(FilterTransform& transform, const ConvolutionFilters& responses,
          ConvolutionFilter& filter) {
    for (std::size_t s = 0; s < responses.size(); ++s) {
        const std::vector<std::span<const float>> views(responses[s].begin(), responses[s].end());
        transform.transform(views, s, filter);
    }
}

/// Unrelated filters, transformed.
std::vector<ConvolutionFilter> make_filters(const ConvolutionCase& c, const ConvolutionShape& shape,
                                            std::uint64_t seed, unsigned count) {
    FilterTransform transform(shape);
    std::vector<ConvolutionFilter> filters;
    for (unsigned k = 0; k < count; ++k) {
        filters.emplace_back(shape);
        fill(transform, decaying_noise(c, seed + k), filters.back());
    }
    return filters;
}

/// Aula's convolver, which exchanges `filters` in turn if there are several, with the renderer's
/// fade.
std::function<void()> start_aula(const ConvolutionCase& c, const ConvolutionShape& shape,
                                 const std::vector<ConvolutionFilter>& filters,
                                 const ConvolutionSignals& signals) {
    struct State {
        Convolver convolver;
        std::size_t block = 0;
        std::size_t exchanges = 0;
    };
    const double apart_samples = kConvolutionRate_hz / kExchange_hz;
    // Exchanges are up to a block late.
    const auto fade =
        static_cast<std::size_t>(std::max(apart_samples - static_cast<double>(c.block), 512.0));
    const auto state = std::make_shared<State>(State{Convolver(shape, fade)});
    return [state, c, apart_samples, &filters, &signals] {
        State& s = *state;
        const auto due =
            static_cast<std::size_t>(static_cast<double>(s.block++ * c.block) / apart_samples);
        if (s.exchanges == 0 || (filters.size() > 1 && due >= s.exchanges)) {
            if (!s.convolver.fading()) {
                s.convolver.exchange(&filters[s.exchanges++ % filters.size()]);
            }
        }
        s.convolver.process(signals.inputs, signals.outputs, c.block);
    };
}

/// Bytes of spectra that a block reads.
double bytes_of_block(const ConvolutionShape& shape, std::size_t block) {
    double bytes = 0;
    for (const PartitionLevel& level : partition_levels(shape)) {
        const double filter_bytes = level.half_precision ? 2 : 4;
        bytes += static_cast<double>(2 * shape.inputs * level.count * block) *
                 (4 + static_cast<double>(shape.outputs) * filter_bytes);
    }
    return bytes;
}

double footprint_bytes(const ConvolutionShape& shape) {
    double bytes = 0;
    for (const PartitionLevel& level : partition_levels(shape)) {
        const double filter_bytes = level.half_precision ? 2 : 4;
        bytes += static_cast<double>(2 * shape.inputs * level.count * level.size) *
                 (4 + static_cast<double>(shape.outputs) * filter_bytes);
    }
    return bytes;
}

Row row_of(const char* bench, const std::string& library, const ConvolutionCase& c) {
    Row row;
    row.figures = {{"bench", bench},
                   {"scene", Value{}},
                   {"basis", "cpu"},
                   {"library", library},
                   {"sources", static_cast<std::int64_t>(c.sources)},
                   {"channels", static_cast<std::int64_t>(c.channels)},
                   {"ir_s", c.response_s},
                   {"block", static_cast<std::int64_t>(c.block)}};
    return row;
}

std::vector<ConvolutionCase> cases_of(const ConvolutionSweep& sweep) {
    std::vector<ConvolutionCase> cases;
    for (const Channels& channels : kChannels) {
        for (const double response_s : sweep.responses_s) {
            for (const std::size_t block : sweep.blocks) {
                cases.push_back({channels.sources, channels.channels, response_s, block});
            }
        }
    }
    return cases;
}

std::string text_of(const ConvolutionCase& c) {
    return std::to_string(c.sources) + " x " + std::to_string(c.channels) + ", " +
           std::to_string(c.taps()) + " taps, blocks of " + std::to_string(c.block);
}

/// One convolver of a case and its times.
struct TimedConvolver {
    std::string name;
    double exchange_hz;
    bool all_threads;
    std::size_t warm_up;
    BlockTimes times;
    std::function<std::function<void()>()> start;
    Value memory_us;
};

void measure_case(const ConvolutionCase& c, std::uint64_t seed, int rounds,
                  std::vector<Row>& rows) {
    const ConvolutionSignals signals(c, seed);
    // Whole segments of the longest partitions. Uniform convolvers need few blocks.
    constexpr std::size_t kLongest = 8192;
    const std::size_t segment_blocks = kLongest / c.block;
    std::vector<TimedConvolver> convolvers;
    std::array<std::vector<ConvolutionFilter>, 2> filters;
    std::array<std::vector<ConvolutionFilter>, 2> one;
    for (const bool half : {false, true}) {
        const ConvolutionShape shape = shape_of(c, half);
        filters[half] = make_filters(c, shape, seed, kFilters);
        one[half] = make_filters(c, shape, seed, 1);
        const Value memory_us =
            read_time_us(footprint_bytes(shape), bytes_of_block(shape, c.block));
        for (const bool exchanging : {false, true}) {
            const auto& used = exchanging ? filters[half] : one[half];
            convolvers.push_back(
                {half ? "aula, half" : "aula", exchanging ? kExchange_hz : 0, false,
                 4 * segment_blocks, BlockTimes(8 * segment_blocks),
                 [&c, shape, &used, &signals] { return start_aula(c, shape, used, signals); },
                 memory_us});
        }
    }
    const ConvolutionFilters responses = decaying_noise(c, seed);
    for (const ConvolutionPeer& peer : convolution_peers()) {
        const std::size_t blocks = peer.uses_threads ? 8 * segment_blocks : 32;
        convolvers.push_back(
            {peer.name, 0, peer.uses_threads, blocks / 2, BlockTimes(blocks),
             [&c, &responses, &signals, peer] { return peer.start(c, responses, signals); },
             Value{}});
    }
    for (int round = 0; round < rounds; ++round) {
        for (TimedConvolver& convolver : convolvers) {
            convolver.times.round(convolver.all_threads, convolver.warm_up, convolver.start());
        }
    }
    std::array<double, 2> aula_us{};
    for (const TimedConvolver& convolver : convolvers) {
        if (convolver.exchange_hz > 0) continue;
        if (convolver.name == "aula") aula_us[0] = convolver.times.mean_us();
        if (convolver.name == "aula, half") aula_us[1] = convolver.times.mean_us();
    }
    for (const TimedConvolver& convolver : convolvers) {
        const double mean_us = convolver.times.mean_us();
        const double worst = convolver.times.worst_over_mean();
        const bool own = convolver.name.rfind("aula", 0) == 0;
        Row row = row_of("convolve", convolver.name, c);
        row.figures.insert(
            row.figures.end(),
            {{"exchange_hz", convolver.exchange_hz},
             {"mean_us", mean_us},
             // The scheduler determines when separate threads compute.
             {"worst_us", convolver.all_threads ? Value{} : Value{worst * mean_us}},
             {"ratio", own ? 1.0 : aula_us[0] / mean_us},
             {"half_ratio", own ? Value{} : Value{aula_us[1] / mean_us}},
             {"worst_over_mean", convolver.all_threads ? Value{} : Value{worst}},
             {"load_percent", mean_us * 1e-4 * kConvolutionRate_hz / static_cast<double>(c.block)},
             {"memory_us", convolver.memory_us}});
        rows.push_back(row);
    }
}

/// The transforms of whole filters alone, from the taps to separate spectra.
class Transforms {
 public:
    Transforms(const ConvolutionCase& c, const ConvolutionShape& shape)
        : case_(c), levels_(partition_levels(shape)) {
        for (const PartitionLevel& level : levels_) {
            transforms_.emplace_back(level.size);
            spectra_.emplace_back(2 * level.size * level.count * c.sources * c.channels);
        }
        const std::size_t largest = levels_.back().size;
        taps_.resize(c.channels);
        work_.resize(2 * largest * c.channels);
        last_.resize(largest * c.channels);
    }

    double time_us_of(const ConvolutionFilters& responses) {
        const double began_us = time_us(CLOCK_THREAD_CPUTIME_ID);
        for (std::size_t l = 0; l < levels_.size(); ++l) {
            const PartitionLevel& level = levels_[l];
            float* spectra = spectra_[l].data();
            for (std::size_t s = 0; s < case_.sources; ++s) {
                for (std::size_t p = 0; p < level.count; ++p) {
                    const std::size_t first = level.first_tap + p * level.size;
                    for (std::size_t o = 0; o < case_.channels; ++o) {
                        const std::vector<float>& response = responses[s][o];
                        taps_[o] = response.data() + first;
                        if (first + level.size <= response.size()) continue;
                        float* const last = last_.data() + o * level.size;
                        const auto end =
                            std::copy(response.begin() + static_cast<std::ptrdiff_t>(first),
                                      response.end(), last);
                        std::fill(end, last + level.size, 0.0F);
                        taps_[o] = last;
                    }
                    transforms_[l].forward_filters(taps_, work_.data(), spectra);
                    spectra += 2 * level.size * case_.channels;
                }
            }
        }
        return time_us(CLOCK_THREAD_CPUTIME_ID) - began_us;
    }

 private:
    ConvolutionCase case_;
    std::vector<PartitionLevel> levels_;
    std::vector<BlockTransform> transforms_;
    std::vector<AlignedVector<float>> spectra_;
    std::vector<const float*> taps_;
    AlignedVector<float> work_;
    AlignedVector<float> last_;
};

}  // namespace

std::vector<Row> measure_convolution(const Settings& settings, const ConvolutionSweep& sweep) {
    const FlushDenormals flush;
    std::vector<Row> rows;
    for (const ConvolutionCase& c : cases_of(sweep)) {
        settings.progress("convolve: " + text_of(c));
        measure_case(c, settings.seed.value_or(1), sweep.rounds, rows);
    }
    return rows;
}

const std::vector<Column>& convolution_columns() {
    static const std::vector<Column> columns{{"library", "library", 0},
                                             {"sources", "sources", 0},
                                             {"channels", "channels", 0},
                                             {"ir_s", "IR s", 1},
                                             {"block", "block", 0},
                                             {"exchange_hz", "exchange Hz", 0},
                                             {"mean_us", "mean us", 1},
                                             {"worst_us", "worst us", 1},
                                             {"worst_over_mean", "worst/mean", 2},
                                             {"load_percent", "% of a core", 2},
                                             {"memory_us", "memory us", 1},
                                             {"ratio", "aula / it", 3},
                                             {"half_ratio", "half / it", 3}};
    return columns;
}

std::vector<Row> measure_preparing(const Settings& settings, const ConvolutionSweep& sweep) {
    std::vector<Row> rows;
    const std::uint64_t seed = settings.seed.value_or(1);
    for (const ConvolutionCase& c : cases_of(sweep)) {
        settings.progress("prepare: " + text_of(c));
        // The last part of each response is replaced by that of another one.
        const std::array<ConvolutionFilters, 2> responses{decaying_noise(c, seed),
                                                          decaying_noise(c, seed + 1)};
        for (const double share : {1.0, 0.2, 0.0}) {
            ConvolutionFilters changing = responses[0];
            const auto first = static_cast<std::ptrdiff_t>(
                std::lround((1 - share) * static_cast<double>(c.taps())));
            const ConvolutionShape shape = shape_of(c, false);
            FilterTransform transform(shape);
            // As many as circulate between threads.
            std::vector<ConvolutionFilter> filters;
            while (filters.size() < kFilters) filters.emplace_back(shape);
            std::vector<Transforms> transforms(kFilters, Transforms(c, shape));
            double min_us = 1e9;
            double fft_us = 1e9;
            for (unsigned round = 0; round < 3 * kFilters; ++round) {
                for (std::size_t s = 0; s < c.sources; ++s) {
                    for (std::size_t o = 0; o < c.channels; ++o) {
                        const std::vector<float>& from = responses[round % 2][s][o];
                        std::copy(from.begin() + first, from.end(), changing[s][o].begin() + first);
                    }
                }
                const double began_us = time_us(CLOCK_THREAD_CPUTIME_ID);
                fill(transform, changing, filters[round % kFilters]);
                const double spent_us = time_us(CLOCK_THREAD_CPUTIME_ID) - began_us;
                const double alone_us = transforms[round % kFilters].time_us_of(changing);
                // The first rounds allocate.
                if (round < kFilters) continue;
                min_us = std::min(min_us, spent_us);
                fft_us = std::min(fft_us, alone_us);
            }
            Row row = row_of("prepare", "aula", c);
            row.figures.insert(row.figures.end(), {{"changed", share},
                                                   {"mean_us", min_us},
                                                   {"fft_us", fft_us},
                                                   {"ratio", min_us / fft_us}});
            rows.push_back(row);
        }
    }
    return rows;
}

const std::vector<Column>& preparing_columns() {
    static const std::vector<Column> columns{
        {"sources", "sources", 0},      {"channels", "channels", 0}, {"ir_s", "IR s", 1},
        {"block", "block", 0},          {"changed", "changed", 1},   {"mean_us", "us", 0},
        {"fft_us", "FFTs alone us", 0}, {"ratio", "it / FFTs", 2}};
    return columns;
}

}  // namespace aula::bench
