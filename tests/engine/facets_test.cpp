// Planes of less than 0.01 m2 have no image sources: rays count the reflections over them.

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "aula/engine/propagation.h"
#include "engine/base/sampling.h"
#include "tests/support/measure.h"
#include "tests/support/rooms.h"
#include "tests/support/statistics.h"

using namespace aula;

namespace {

/// Energy of all reflections, image sources included, over restarts of four frames each.
test::Estimate reflected(const Scene& scene, const Simulation& simulation, bool from_listener) {
    Propagation propagation(scene, simulation);
    if (from_listener) propagation.emit_from_listeners();
    std::vector<double> samples;
    for (int k = 0; k < 12; ++k) {
        propagation.restart(derive_seed(test::test_seed(), k));
        double energy = 0;
        for (int f = 0; f < 4; ++f) {
            propagation.step(test::static_input(scene));
            if (simulation.estimator == Estimator::pt || f == 3) {
                const double bins = test::total(propagation.response(0));
                energy += simulation.estimator == Estimator::pt ? bins / 4 : bins;
            }
        }
        for (const SoundPath& path : propagation.response(0).paths) {
            energy += double{path.energy[0]};
        }
        samples.push_back(energy);
    }
    return test::estimate(samples);
}

}  // namespace

TEST_CASE("paths over mirrors and facets count once, by image sources or by rays") {
    // A faceted ball in a room of mirrors: its facets have 0.003 m2.
    Scene scene = test::grey_room(test::box(Vec3(5, 4, 3)), 0.05F, 0, Vec3(1.2F, 1.6F, 1.3F),
                                  Vec3(3.6F, 2.7F, 1.6F));
    Object ball = test::icosphere(0.6F, 3);
    for (Vec3& vertex : ball.vertices) vertex += Vec3(2.6F, 0.9F, 1.4F);
    scene.objects.push_back(ball);
    for (const int order : {1, 2, 3}) {
        for (const Estimator estimator : {Estimator::pt, Estimator::patch}) {
            for (const bool from_listener : {false, true}) {
                if (from_listener && estimator != Estimator::patch) continue;
                Simulation simulation = test::with(scene, estimator, 0.06F);
                simulation.order = order;
                simulation.rays = 20'000;
                simulation.listener_radius_m = 0.2F;
                const test::Estimate by_rays = reflected(scene, simulation, from_listener);
                simulation.specular_order = 2;
                const test::Estimate e = reflected(scene, simulation, from_listener);
                CAPTURE(order, estimator_name(estimator), from_listener, e.mean, by_rays.mean);
                const double error = std::hypot(e.standard_error, by_rays.standard_error);
                CHECK(std::abs(e.mean - by_rays.mean) < test::kFamilyZ * error);
                // Companion: the image sources alone lack the ball's reflections.
                CHECK(error < 0.02 * e.mean);
            }
        }
    }
}

TEST_CASE("the edges of a facet do not diffract a reflection without an image source") {
    // A slat of 0.6 m: its faces are smaller than 0.01 m2, or larger.
    const auto bent_reflections = [](float width_m) {
        Scene scene = test::grey_room(
            test::box(Vec3(width_m, width_m, 0.6F), 0, Vec3(-width_m, -width_m / 2, -0.3F)), 0, 0,
            Vec3(2, 0.004F, 0.02F), Vec3(1.5F, -0.003F, 0.012F));
        scene.simulation.direct = true;
        scene.simulation.specular_order = 3;
        Simulation simulation = test::with(scene, Estimator::patch, 0.05F);
        simulation.diffraction_order = 2;
        Propagation propagation(scene, simulation);
        for (int f = 0; f < 20; ++f) propagation.step(test::static_input(scene));
        int count = 0;
        for (const SoundPath& path : propagation.response(0).paths) count += path.order > 0;
        return count;
    };
    CHECK(bent_reflections(0.015F) == 0);  // 0.009 m2
    CHECK(bent_reflections(0.018F) > 0);   // 0.0108 m2
}
