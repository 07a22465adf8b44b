#include "engine/waves/wall_admittance.h"

#include <algorithm>
#include <cmath>

#include "engine/base/bisection.h"

namespace aula {

namespace {

/// The admittance with kHighestPassiveAbsorption, the maximum of Paris' formula: higher ones absorb
/// less (`test_waves "wall_admittance: *"`).
constexpr double kHighestAdmittance = 0.64;

}  // namespace

double absorption_of_admittance(double admittance) {
    if (!(admittance > 0)) return 0;
    const double b = admittance;
    return 8 * b * (1 + b / (1 + b) - 2 * b * std::log1p(1 / b));
}

double admittance_of_absorption(double absorption) {
    const double wanted = std::min(absorption, kHighestPassiveAbsorption);
    return bisected(0, kHighestAdmittance,
                    [&](double b) { return absorption_of_admittance(b) < wanted; });
}

}  // namespace aula
