#include "aula/engine/simulation.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <iterator>

#include "aula/exception.h"

namespace aula {

namespace {

struct EstimatorName {
    Estimator estimator;
    const char* name;
};

constexpr EstimatorName kEstimatorNames[] = {
    {Estimator::pt, "pt"},
    {Estimator::dpc_published, "dpc-published"},
    {Estimator::dpc, "dpc"},
    {Estimator::patch, "patch"},
};

}  // namespace

const char* estimator_name(Estimator estimator) {
    const auto* entry = std::find_if(std::begin(kEstimatorNames), std::end(kEstimatorNames),
                                     [=](const auto& e) { return e.estimator == estimator; });
    assert(entry != std::end(kEstimatorNames));
    return entry->name;
}

std::optional<Estimator> estimator_from_name(const std::string& name) {
    for (const EstimatorName& entry : kEstimatorNames) {
        if (name == entry.name) return entry.estimator;
    }
    return std::nullopt;
}

int Simulation::window_frames() const {
    constexpr float kMax = 1e9F;  // fits an int
    return static_cast<int>(std::clamp(std::round(response_time_s * frame_rate_hz), 1.0F, kMax));
}

void Simulation::check() const {
    const auto need = [](bool holds, const char* what) {
        if (!holds) throw InputError(std::string("simulation: ") + what);
    };
    need(rays >= 1, "rays is below 1");
    need(order >= 0, "order is below 0");
    need(specular_order >= 0, "specular_order is below 0");
    need(specular_order <= Simulation::kHighestSpecularOrder, "specular_order is above 100");
    need(diffraction_order >= 0, "diffraction_order is below 0");
    need(diffraction_order <= Simulation::kHighestDiffractionOrder, "diffraction_order is above 4");
    need(patch_size_m > 0, "patch_size_m is not above 0");
    need(listener_radius_m > 0, "listener_radius_m is not above 0");
    need(frame_rate_hz > 0, "frame_rate_hz is not above 0");
    need(response_time_s >= 0, "response_time_s is below 0");
    need(memory_mb >= 1, "memory_mb is below 1");
    need(!threads || *threads >= 1, "threads is below 1");
    need(!ir_length_s || (*ir_length_s > 0 && *ir_length_s <= 10),
         "ir_length_s is not between 0 and 10");
}

}  // namespace aula
