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

struct QualityName {
    Quality quality;
    const char* name;
};

constexpr QualityName kQualityNames[] = {
    {Quality::draft, "draft"},
    {Quality::normal, "normal"},
    {Quality::fine, "fine"},
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

const char* quality_name(Quality quality) {
    const auto* entry = std::find_if(std::begin(kQualityNames), std::end(kQualityNames),
                                     [=](const auto& e) { return e.quality == quality; });
    assert(entry != std::end(kQualityNames));
    return entry->name;
}

std::optional<Quality> quality_from_name(const std::string& name) {
    for (const QualityName& entry : kQualityNames) {
        if (name == entry.name) return entry.quality;
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
    const auto is_within = [](auto value, auto lowest, auto highest) {
        return value >= lowest && value <= highest;
    };
    const auto is_above_0 = [](float value, float highest) {
        return value > 0 && value <= highest;
    };
    need(is_within(ray_count(), 1, kMaxRays), "rays is not between 1 and 200000");
    need(is_within(order, 0, kMaxOrder), "order is not between 0 and 1000000");
    need(is_within(specular_order, 0, kHighestSpecularOrder),
         "specular_order is not between 0 and 100");
    need(is_within(diffraction_order, 0, kHighestDiffractionOrder),
         "diffraction_order is not between 0 and 4");
    need(is_above_0(patch_size_m, kMaxLength_m), "patch_size_m is not above 0, at most 1e6");
    need(is_above_0(listener_radius_m, kMaxLength_m),
         "listener_radius_m is not above 0, at most 1e6");
    need(is_above_0(frame_rate_hz, kMaxFrameRate_hz), "frame_rate_hz is not above 0, at most 1000");
    need(waves_hz == 0 || is_within(waves_hz, kLowestWaves_hz, kHighestWaves_hz),
         "waves_hz is not 0 or between 20 and 500");
    need(is_within(response_time_s, 0.0F, kMaxResponseTime_s),
         "response_time_s is not between 0 and 3600");
    need(is_within(memory_mb, 1, kMaxMemory_mb), "memory_mb is not between 1 and 1000000");
    need(!threads || is_within(*threads, 1, kMaxThreads), "threads is not between 1 and 1024");
    need(!ir_length_s || is_above_0(*ir_length_s, kMaxIrLength_s),
         "ir_length_s is not above 0, at most 10");
}

}  // namespace aula
