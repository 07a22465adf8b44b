#include "apps/session/offline/measurement_error.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "aula/engine/room_acoustics.h"

namespace aula {

namespace {

using Values =
    std::array<std::array<std::optional<double>, kBandCount>, kMeasuredParameters.size()>;

/// Level and C80 in dB, T30 and EDT as natural logarithms, which makes their errors relative.
Values values_of(const EnergyResponse& response) {
    const RoomParameters parameters = room_parameters(response);
    const auto logarithm = [](const std::optional<double>& x) {
        return x && *x > 0 ? std::optional(std::log(*x)) : std::nullopt;
    };
    Values values;
    for (std::size_t band = 0; band < kBandCount; ++band) {
        const double total = response.total(band);
        if (total > 0) values[0][band] = 10 * std::log10(total);
        values[1][band] = parameters[band].c80_db;
        values[2][band] = logarithm(parameters[band].t30_s);
        values[3][band] = logarithm(parameters[band].edt_s);
    }
    return values;
}

}  // namespace

double wanted_error(MeasuredParameter parameter) {
    constexpr std::array<double, kMeasuredParameters.size()> kWanted{0.05, 0.1, 0.01, 0.01};
    return kWanted[static_cast<std::size_t>(parameter)];
}

void WindowedMean::add(const EnergyResponse& window) {
    const std::size_t group = windows_ % kMaxGroups;
    if (group == groups_.size()) groups_.emplace_back();
    groups_[group].add(window);
    ++windows_;
}

EnergyResponse WindowedMean::mean() const {
    ResponseMean all;
    for (const ResponseMean& group : groups_) all.add(group);
    return all.value();
}

WindowedMean::Errors WindowedMean::standard_errors() const {
    const Values of_mean = values_of(mean());
    std::vector<Values> without;
    for (std::size_t left_out = 0; left_out < groups_.size(); ++left_out) {
        ResponseMean rest;
        for (std::size_t g = 0; g < groups_.size(); ++g)
            if (g != left_out) rest.add(groups_[g]);
        without.push_back(values_of(rest.value()));
    }
    Errors errors{};
    for (std::size_t p = 0; p < errors.size(); ++p) {
        for (std::size_t band = 0; band < kBandCount; ++band) {
            if (!of_mean[p][band]) continue;
            // A parameter near the limit of the decay range may be absent in some groups.
            double count = 0;
            double squares = 0;
            for (const Values& values : without) {
                if (!values[p][band]) continue;
                ++count;
                squares += std::pow(*values[p][band] - *of_mean[p][band], 2);
            }
            // Jackknife with n groups: the variance is (n - 1)/n times the sum of squares.
            const auto n = static_cast<double>(groups_.size());
            if (count > 0) errors[p][band] = std::sqrt((n - 1) / count * squares);
        }
    }
    return errors;
}

double WindowedMean::error_margin() const {
    return 1 + 1 / std::sqrt(2 * static_cast<double>(groups_.size() - 1));
}

}  // namespace aula
