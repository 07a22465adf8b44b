#include "apps/room/live/growing_length.h"

#include <algorithm>

#include "aula/engine/propagation.h"

namespace aula {

std::optional<double> room_length_s(const Scene& scene) {
    if (scene.simulation.ir_length_s) return {};
    Simulation simulation = scene.simulation;
    simulation.estimator = Estimator::pt;  // no patches, and nothing else that is not needed
    simulation.rays = 1;
    simulation.specular_order = 0;
    simulation.diffraction_order = 0;
    return double{static_cast<float>(Propagation(scene, simulation).response_length_s())};
}

/// Frames and convolution cost in proportion to the length.
double first_length_s(double room_length_s) {
    constexpr double kLongest_s = 4;
    return std::min(room_length_s, kLongest_s);
}

void GrowingLength::fit(Scene& scene, std::optional<double> room_s) {
    const std::lock_guard lock(mutex_);
    changes_ = false;
    if (!room_s) {
        load_.reset();
        return;
    }
    const LiveLoad::Full full{.rays = scene.simulation.ray_count(),
                              .length_s = *room_s,
                              .rays_fall = false,
                              .length_falls = true};
    if (!load_ || load_->full().length_s != *room_s)
        load_.emplace(full, full.rays, first_length_s(*room_s));
    else
        load_->change(full, full.rays, load_->length_s());
    length_s_ = load_->length_s();
    scene.simulation.ir_length_s = static_cast<float>(length_s_);
}

std::shared_ptr<void> GrowingLength::hear() {
    const std::lock_guard lock(mutex_);
    ++rooms_;
    return {this, [](GrowingLength* length) {
                const std::lock_guard lock_length(length->mutex_);
                --length->rooms_;
            }};
}

bool GrowingLength::add(double took_s, double period_s) {
    const std::lock_guard lock(mutex_);
    if (!load_ || changes_) return false;
    if (rooms_ > 1) {
        load_->restart();
        return false;
    }
    load_->add(took_s, period_s, false);
    const LiveLoad::Full& full = load_->full();
    if (const double first_s = first_length_s(full.length_s); load_->length_s() < first_s)
        load_->change(full, load_->rays(), first_s);
    changes_ = load_->length_s() != length_s_;
    return changes_;
}

}  // namespace aula
