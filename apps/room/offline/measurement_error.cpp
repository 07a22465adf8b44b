#include "apps/room/offline/measurement_error.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "aula/engine/room_acoustics.h"

namespace aula {

namespace {

/// Level and C80 in dB, T30 and EDT as natural logarithms, which makes their errors relative:
/// [parameter * kBandCount + band].
MeasuredValues decisive_values(const EnergyResponse& response) {
    const RoomParameters parameters = room_parameters(response);
    const auto logarithm = [](const std::optional<double>& x) {
        return x && *x > 0 ? std::optional(std::log(*x)) : std::nullopt;
    };
    MeasuredValues values(kMeasuredParameters.size() * kBandCount);
    for (std::size_t band = 0; band < kBandCount; ++band) {
        const double total = response.total(band);
        if (total > 0) values[band] = 10 * std::log10(total);
        values[kBandCount + band] = parameters[band].c80_db;
        values[2 * kBandCount + band] = logarithm(parameters[band].t30_s);
        values[3 * kBandCount + band] = logarithm(parameters[band].edt_s);
    }
    return values;
}

}  // namespace

double wanted_error(const MeasurementLimits& limits, MeasuredParameter parameter) {
    switch (parameter) {
        case MeasuredParameter::level:
            return limits.level_db;
        case MeasuredParameter::c80:
            return limits.c80_db;
        case MeasuredParameter::t30:
            return limits.t30;
        case MeasuredParameter::edt:
            return limits.edt;
    }
    return 0;
}

void WindowedMean::add(const EnergyResponse& window) {
    const std::size_t group = windows_ % max_groups_;
    if (group == groups_.size()) groups_.emplace_back();
    groups_[group].add(window);
    ++windows_;
}

EnergyResponse WindowedMean::mean() const {
    ResponseMean all;
    for (const ResponseMean& group : groups_) all.add(group);
    return all.value();
}

MeasuredValues WindowedMean::standard_errors(
    const std::function<MeasuredValues(const EnergyResponse&)>& values_of) const {
    const MeasuredValues of_mean = values_of(mean());
    std::vector<MeasuredValues> without;
    for (std::size_t left_out = 0; left_out < groups_.size(); ++left_out) {
        ResponseMean rest;
        for (std::size_t g = 0; g < groups_.size(); ++g)
            if (g != left_out) rest.add(groups_[g]);
        without.push_back(values_of(rest.value()));
    }
    MeasuredValues errors(of_mean.size());
    for (std::size_t i = 0; i < of_mean.size(); ++i) {
        if (!of_mean[i]) continue;
        // A parameter near the limit of the decay range may be absent in some groups.
        double count = 0;
        double squares = 0;
        for (const MeasuredValues& values : without) {
            if (!values[i]) continue;
            ++count;
            squares += std::pow(*values[i] - *of_mean[i], 2);
        }
        // Jackknife with n groups: the variance is (n - 1)/n times the sum of squares.
        const auto n = static_cast<double>(groups_.size());
        if (count > 0) errors[i] = std::sqrt((n - 1) / count * squares);
    }
    return errors;
}

WindowedMean::Errors WindowedMean::standard_errors() const {
    const MeasuredValues values = standard_errors(decisive_values);
    Errors errors{};
    for (std::size_t p = 0; p < errors.size(); ++p)
        for (std::size_t band = 0; band < kBandCount; ++band)
            errors[p][band] = values[p * kBandCount + band].value_or(0);
    return errors;
}

double WindowedMean::error_margin() const {
    return 1 + 1 / std::sqrt(2 * static_cast<double>(groups_.size() - 1));
}

}  // namespace aula
