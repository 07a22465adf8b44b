#pragma once

namespace aula {

/// The upper end of the interval in which a condition ends to hold, between `low`, where it holds,
/// and `high`. Exact to double precision for a root down to 1 % of the interval.
template <typename Condition>
double bisected(double low, double high, const Condition& holds) {
    constexpr int kHalvings = 60;  // 53 digits, and seven for the position of the root
    for (int i = 0; i < kHalvings; ++i) {
        const double middle = (low + high) / 2;
        (holds(middle) ? low : high) = middle;
    }
    return high;
}

}  // namespace aula
