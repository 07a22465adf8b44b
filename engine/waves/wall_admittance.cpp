#include "engine/waves/wall_admittance.h"

#include <algorithm>
#include <cmath>

namespace aula {

namespace {

/// The admittance with kHighestPassiveAbsorption; higher ones absorb less.
constexpr double kHighestAdmittance = 0.64;

}  // namespace

double absorption_of_admittance(double admittance) {
    if (!(admittance > 0)) return 0;
    const double b = admittance;
    return 8 * b * (1 + b / (1 + b) - 2 * b * std::log1p(1 / b));
}

double admittance_of_absorption(double absorption) {
    const double wanted = std::min(absorption, kHighestPassiveAbsorption);
    double low = 0;
    double high = kHighestAdmittance;
    for (int i = 0; i < 60; ++i) {
        const double middle = (low + high) / 2;
        (absorption_of_admittance(middle) < wanted ? low : high) = middle;
    }
    return high;
}

}  // namespace aula
