#pragma once

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <vector>

namespace aula::test {

/// The seed of a statistical test: the environment variable AULA_TEST_SEED, else 1.
inline std::uint64_t test_seed() {
    const char* given = std::getenv("AULA_TEST_SEED");
    return given ? std::strtoull(given, nullptr, 10) : 1;
}

/// Mean of independent samples and its standard error.
struct Estimate {
    double mean = 0;
    double standard_error = 0;

    /// Distance from a value in standard errors.
    double z(double value) const { return (mean - value) / standard_error; }
};

inline Estimate estimate(const std::vector<double>& samples) {
    const auto n = static_cast<double>(samples.size());
    Estimate e;
    for (double x : samples) e.mean += x / n;
    double square = 0;
    for (double x : samples) square += (x - e.mean) * (x - e.mean);
    e.standard_error = std::sqrt(square / (n * (n - 1)));
    return e;
}

/// Threshold of |z| for a two-sided test in a family of up to 150, at a significance of 1 % for the
/// whole family (Bonferroni), with at least about 16 samples.
inline constexpr double kFamilyZ = 4.0;

/// Least |z| of a companion that must fail.
inline constexpr double kRefutedZ = 6.0;

}  // namespace aula::test
