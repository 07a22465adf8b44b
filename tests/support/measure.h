#pragma once

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "aula/engine/propagation.h"
#include "tests/support/statistics.h"

namespace aula::test {

inline constexpr std::array<Estimator, 4> kAllEstimators{Estimator::pt, Estimator::dpc_published,
                                                         Estimator::dpc, Estimator::patch};

/// Frame input with sources and listener static at the scene's positions.
FrameInput static_input(const Scene& scene, double time_s = 0);

/// Independent restarts of `frames` frames each. Returns `read` of each restart's last response.
std::vector<double> restarts(Propagation& propagation, const Scene& scene, int count, int frames,
                             const std::function<double(const EnergyResponse&)>& read);

/// The scene's settings with another estimator, length of the response and tau.
Simulation with(const Scene& scene, Estimator estimator, float ir_length_s,
                float response_time_s = 0.5F);

/// Energy of the bins of a band, without the discrete paths, in 1/m2.
double total(const EnergyResponse& response, std::size_t band = 0);

/// Describes an invalid value: an energy negative or not finite, a direction longer than its
/// energy. Empty if the response is valid.
std::string fault(const EnergyResponse& response);

/// True if two responses are equal to the bit.
bool same_bits(const EnergyResponse& a, const EnergyResponse& b);

/// Energy of a band between two times in 1/m2; bins are split uniformly in time.
double energy_between(const EnergyResponse& response, double begin_s, double end_s,
                      std::size_t band = 0);

/// Mean energies of the responses of `frames` consecutive frames.
EnergyResponse mean_response(Propagation& propagation, const Scene& scene, int frames);

/// Rate s of a decay exp(-s t) in 1/s: least-squares fit to the logarithm of the energy in `steps`
/// equal intervals between two times.
double decay_rate(const EnergyResponse& response, double begin_s, double end_s, int steps);

}  // namespace aula::test
