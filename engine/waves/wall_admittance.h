#pragma once

namespace aula {

/// The absorption coefficient in a diffuse field of a locally reacting wall with a real specific
/// admittance, 0..1 (Paris 1928).
double absorption_of_admittance(double admittance);

/// The highest absorption coefficient in a diffuse field of a wall with a real admittance: the
/// maximum of Paris' formula.
inline constexpr double kHighestPassiveAbsorption = 0.951;

/// The specific admittance of a locally reacting wall with a diffuse-field absorption coefficient:
/// the lower of two. Higher coefficients than kHighestPassiveAbsorption count as that.
double admittance_of_absorption(double absorption);

}  // namespace aula
