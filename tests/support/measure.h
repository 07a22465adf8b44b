#pragma once

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "engine/propagation.h"
#include "tests/support/statistics.h"

namespace aula::test {

inline constexpr std::array<Estimator, 4> kAllEstimators{Estimator::pt, Estimator::dpc_published,
                                                         Estimator::dpc, Estimator::patch};

/// The input of a frame in which everything stands where the scene has it.
FrameInput standing(const Scene& scene, double time_s = 0);

/// Independent restarts of `frames` frames each; from each a number, read from the last response.
std::vector<double> restarts(Propagation& propagation, const Scene& scene, int count, int frames,
                             const std::function<double(const EnergyResponse&)>& read);

/// The scene's settings with another estimator, length of the response and tau.
Simulation with(const Scene& scene, Estimator estimator, float ir_length_s,
                float response_time_s = 0.5F);

/// All that an estimator found in a band: the bins, without the discrete paths. 1/m2
double total(const EnergyResponse& response, std::size_t band = 0);

/// What no response may have: energies that are negative or not finite, directions longer than
/// their energy. Empty if all is well, else what is wrong and where.
std::string fault(const EnergyResponse& response);

/// True if two responses agree in every bit.
bool same_bits(const EnergyResponse& a, const EnergyResponse& b);

/// Energy of a band between two times, bins split uniformly in time. 1/m2
double energy_between(const EnergyResponse& response, double begin_s, double end_s,
                      std::size_t band = 0);

/// The mean of responses of `frames` consecutive frames, energies only.
EnergyResponse mean_response(Propagation& propagation, const Scene& scene, int frames);

/// The rate s of a decay exp(-s t) in 1/s: least squares through the logarithms of the energy in
/// `steps` equal parts between two times.
double decay_rate(const EnergyResponse& response, double begin_s, double end_s, int steps);

}  // namespace aula::test
