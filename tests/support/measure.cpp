#include "tests/support/measure.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "engine/base/sampling.h"

namespace aula::test {

FrameInput static_input(const Scene& scene, double time_s) {
    FrameInput input;
    input.time_s = time_s;
    for (const Source& source : scene.sources) {
        input.sources.push_back(source.position);
        input.source_rotations.push_back(source.pose_at(time_s).rotation());
    }
    input.listeners.push_back(scene.listener.pose.position);
    return input;
}

std::vector<double> restarts(Propagation& propagation, const Scene& scene, int count, int frames,
                             const std::function<double(const EnergyResponse&)>& read) {
    std::vector<double> samples;
    for (int i = 0; i < count; ++i) {
        propagation.restart(derive_seed(test_seed(), i));
        for (int f = 0; f < frames; ++f) propagation.step(static_input(scene));
        samples.push_back(read(propagation.response(0)));
    }
    return samples;
}

Simulation with(const Scene& scene, Estimator estimator, float ir_length_s, float response_time_s) {
    Simulation simulation = scene.simulation;
    simulation.estimator = estimator;
    simulation.ir_length_s = ir_length_s;
    simulation.response_time_s = response_time_s;
    return simulation;
}

double total(const EnergyResponse& response, std::size_t band) {
    return energy_between(response, 0, response.bins.length_s(), band);
}

std::string fault(const EnergyResponse& response) {
    const auto bad = [](const Bands& energy) {
        return std::any_of(energy.value.begin(), energy.value.end(),
                           [](float e) { return !(e >= 0) || !std::isfinite(e); });
    };
    for (std::size_t k = 0; k < response.bins.count(); ++k) {
        const std::string place = " in bin " + std::to_string(k);
        if (bad(response.energy[k])) return "energy negative or not finite" + place;
        const float length = glm::length(response.directions[k].intensity);
        if (!(length <= response.energy[k].sum() * (1 + 1e-4F))) {
            return "intensity above its energy" + place;  // rounding of some 1000 arrivals
        }
    }
    for (std::size_t i = 0; i < response.paths.size(); ++i) {
        const SoundPath& path = response.paths[i];
        const std::string place = " of path " + std::to_string(i);
        if (bad(path.energy)) return "energy negative or not finite" + place;
        if (!(path.length_m >= 0) || !std::isfinite(path.length_m)) return "bad length" + place;
        // Shorter than 1 near the listener.
        if (!(glm::length(path.direction) < 1 + 1e-5F)) return "bad direction" + place;
    }
    return "";
}

bool same_bits(const EnergyResponse& a, const EnergyResponse& b) {
    const auto same_path = [](const SoundPath& p, const SoundPath& q) {
        return p.order == q.order && p.length_m == q.length_m && p.direction == q.direction &&
               p.energy == q.energy && p.key == q.key && p.edges == q.edges;
    };
    return a.energy == b.energy && a.directions == b.directions &&
           std::equal(a.paths.begin(), a.paths.end(), b.paths.begin(), b.paths.end(), same_path);
}

double energy_between(const EnergyResponse& response, double begin_s, double end_s,
                      std::size_t band) {
    double sum = 0;
    for (std::size_t k = 0; k < response.bins.count(); ++k) {
        const double begin = response.bins.begin_s(k);
        const double end = response.bins.end_s(k);
        const double overlap = std::min(end, end_s) - std::max(begin, begin_s);
        if (overlap > 0) sum += double{response.energy[k][band]} * overlap / (end - begin);
    }
    return sum;
}

EnergyResponse mean_response(Propagation& propagation, const Scene& scene, int frames) {
    EnergyResponse mean;
    std::vector<std::array<double, kBandCount>> sum;
    for (int f = 0; f < frames; ++f) {
        propagation.step(static_input(scene));
        mean = propagation.response(0);
        sum.resize(mean.bins.count());
        for (std::size_t k = 0; k < sum.size(); ++k) {
            for (std::size_t b = 0; b < kBandCount; ++b) sum[k][b] += double{mean.energy[k][b]};
        }
    }
    for (std::size_t k = 0; k < sum.size(); ++k) {
        for (std::size_t b = 0; b < kBandCount; ++b) {
            mean.energy[k][b] = static_cast<float>(sum[k][b] / frames);
        }
    }
    return mean;
}

double decay_rate(const EnergyResponse& response, double begin_s, double end_s, int steps) {
    const double step_s = (end_s - begin_s) / steps;
    double t_mean = 0;
    double y_mean = 0;
    std::vector<double> t;
    std::vector<double> y;
    for (int i = 0; i < steps; ++i) {
        t.push_back(begin_s + (i + 0.5) * step_s);
        y.push_back(
            std::log(energy_between(response, begin_s + i * step_s, begin_s + (i + 1) * step_s)));
        t_mean += t.back() / steps;
        y_mean += y.back() / steps;
    }
    double ty = 0;
    double tt = 0;
    for (std::size_t i = 0; i < t.size(); ++i) {
        ty += (t[i] - t_mean) * (y[i] - y_mean);
        tt += (t[i] - t_mean) * (t[i] - t_mean);
    }
    return -ty / tt;
}

}  // namespace aula::test
