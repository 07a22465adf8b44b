#include "apps/documents/position_average.h"

#include <cmath>

namespace aula {

namespace {

/// Averages the values that `of` finds in all parameters.
template <typename Of>
void average(PositionAverage& out, std::span<const PairParameters* const> all, const Of& of) {
    double count = 0;
    double sum = 0;
    for (const PairParameters* const parameters : all) {
        const MeasuredValue& value = of(*parameters);
        if (!value.value) continue;
        ++count;
        sum += *value.value;
    }
    if (count == 0) return;
    MeasuredValue& mean = of(out.mean);
    mean.value = sum / count;
    of(out.counts).value = count;
    if (count < 2) return;
    double squares = 0;
    for (const PairParameters* const parameters : all) {
        const MeasuredValue& value = of(*parameters);
        if (value.value) squares += std::pow(*value.value - *mean.value, 2);
    }
    of(out.deviation).value = std::sqrt(squares / (count - 1));
}

}  // namespace

PositionAverage average_over_positions(std::span<const PairParameters* const> all) {
    PositionAverage out;
    out.positions = all.size();
    for (std::size_t p = 0; p < kAcousticParameterCount; ++p) {
        for (std::size_t b = 0; b < kBandCount; ++b)
            average(
                out, all, [&](auto& of) -> auto& { return of.octaves[p][b]; });
        average(
            out, all, [&](auto& of) -> auto& { return of.broadband[p]; });
    }
    average(
        out, all, [](auto& of) -> auto& { return of.sti; });
    return out;
}

std::vector<const PairParameters*> audible_parameters(const Measurement& measurement,
                                                      std::span<const char> in_room) {
    std::vector<const PairParameters*> all;
    for (std::size_t pair = 0; pair < measurement.parameters.size(); ++pair)
        if (measurement.audible[pair] && in_room[pair])
            all.push_back(&measurement.parameters[pair]);
    return all;
}

}  // namespace aula
