#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include "apps/room/offline/response_mean.h"
#include "aula/measurement.h"

namespace aula {

/// The parameters whose errors end a measurement.
enum class MeasuredParameter { level, c80, t30, edt };

inline constexpr std::array<MeasuredParameter, 4> kMeasuredParameters{
    MeasuredParameter::level, MeasuredParameter::c80, MeasuredParameter::t30,
    MeasuredParameter::edt};

/// The octaves whose errors are evaluated: 125 Hz to 4 kHz.
inline constexpr std::size_t kFirstMeasuredBand = 1;
inline constexpr std::size_t kEndMeasuredBand = 7;

/// Largest accepted standard error of a parameter: in dB for level and C80, else relative.
double wanted_error(const MeasurementLimits& limits, MeasuredParameter parameter);

/// Values that a response may have or not.
using MeasuredValues = std::vector<std::optional<double>>;

/// The mean response of independent windows, and the standard errors of parameters of that mean by
/// the jackknife (Efron 1982): the parameters are computed with each group of windows left out in
/// turn. The errors are therefore those of parameters of the mean, even if these depend on the
/// response nonlinearly.
class WindowedMean {
 public:
    /// Larger numbers of windows are combined into `max_groups` groups, at least 2.
    explicit WindowedMean(std::size_t max_groups = kMaxGroups)
        : max_groups_(std::max<std::size_t>(max_groups, 2)) {}

    static constexpr std::size_t kMaxGroups = 32;

    void add(const EnergyResponse& window);

    std::size_t windows() const { return windows_; }

    EnergyResponse mean() const;

    using Errors = std::array<std::array<double, kBandCount>, kMeasuredParameters.size()>;

    /// Standard errors of the mean's parameters, [parameter][band], in the units of wanted_error();
    /// 0 where the mean does not have the parameter. Requires at least two windows.
    Errors standard_errors() const;

    /// Standard errors of any values of the mean, in their units; empty where the mean does not
    /// have the value. Requires at least two windows.
    MeasuredValues standard_errors(
        const std::function<MeasuredValues(const EnergyResponse&)>& values_of) const;

    /// Relative margin for the uncertainty of a standard error estimated from this number of
    /// groups: one standard deviation of the estimate, 1 / sqrt(2 (n - 1)).
    double error_margin() const;

 private:
    std::size_t max_groups_;
    std::vector<ResponseMean> groups_;
    std::size_t windows_ = 0;
};

}  // namespace aula
