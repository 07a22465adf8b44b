// Rays from either end give the same responses.

#include <catch2/catch.hpp>
#include <cmath>

#include "aula/engine/propagation.h"
#include "engine/base/sampling.h"
#include "tests/support/measure.h"
#include "tests/support/rooms.h"
#include "tests/support/statistics.h"

namespace reciprocity_test {

using namespace aula;

namespace {

constexpr int kRestarts = 32;
constexpr int kMoves = 3;  // frames until only a static listener emits rays

/// A room whose walls differ from band to band, with air.
Scene colourful_room() {
    Scene scene = test::grey_room(test::box(Vec3(5, 4, 3)), 0.2F, 1, Vec3(1.2F, 1.1F, 1.5F),
                                  Vec3(3.7F, 2.9F, 1.2F));
    scene.materials[0].absorption = {{0.1F, 0.2F, 0.3F, 0.4F, 0.5F, 0.2F, 0.1F, 0.3F}};
    scene.materials[0].scattering = {{0.1F, 0.2F, 0.4F, 0.6F, 0.8F, 1.0F, 0.3F, 0.0F}};
    scene.medium.air_absorption = true;
    scene.simulation.ir_length_s = 0.2F;
    scene.simulation.rays = 400;
    scene.simulation.specular_order = 1;
    scene.simulation.patch_size_m = 0.25F;
    return scene;
}

/// Compared figures: energies of bands and intensities, early and late.
using Figures = std::vector<std::vector<double>>;

void read(const EnergyResponse& response, Figures& figures) {
    std::size_t figure = 0;
    const auto add = [&](double value) {
        if (figures.size() <= figure) figures.emplace_back();
        figures[figure++].push_back(value);
    };
    const double edges_s[] = {0, 0.02, 0.05, 0.2};
    for (int part = 0; part < 3; ++part) {
        for (const std::size_t band : {0U, 3U, 5U, 7U}) {
            add(test::energy_between(response, edges_s[part], edges_s[part + 1], band));
        }
        double intensity[3] = {0, 0, 0};
        for (std::size_t k = 0; k < response.bins.count(); ++k) {
            const double begin_s = response.bins.begin_s(k);
            if (begin_s < edges_s[part] || begin_s >= edges_s[part + 1]) continue;
            for (int axis = 0; axis < 3; ++axis)
                intensity[axis] += double{response.directions[k].intensity[axis]};
        }
        for (const double i : intensity) add(i);
    }
}

/// Rays from the source: everything is static.
Figures from_source(const Scene& scene) {
    Propagation propagation(scene, scene.simulation);
    Figures figures;
    for (int i = 0; i < kRestarts; ++i) {
        propagation.restart(derive_seed(test::test_seed(), i));
        for (int f = 0; f < 3; ++f) propagation.step(test::static_input(scene));
        read(propagation.response(0), figures);
    }
    return figures;
}

/// Rays from the listener: the source approaches in jumps, the last one to its position.
Figures from_listener(const Scene& scene, std::size_t listener_count = 1) {
    Propagation propagation(scene, scene.simulation, listener_count);
    Figures figures;
    for (int i = 0; i < kRestarts; ++i) {
        propagation.restart(derive_seed(test::test_seed(), 1, i));
        FrameInput input = test::static_input(scene);
        if (listener_count == 2) input.listeners = {Vec3(2, 3.5F, 0.5F), input.listeners[0]};
        const Vec3 position = input.sources[0];
        for (int f = 0; f <= kMoves; ++f) {
            input.sources[0] =
                f < kMoves ? Vec3(4.5F, 0.5F + static_cast<float>(f), 2.5F) : position;
            propagation.step(input);
        }
        read(propagation.response(0, listener_count - 1), figures);
    }
    return figures;
}

/// Rays from the listener: the source turns at its position, at last to its orientation.
Figures from_listener_for_turns(const Scene& scene) {
    Propagation propagation(scene, scene.simulation);
    Figures figures;
    for (int i = 0; i < kRestarts; ++i) {
        propagation.restart(derive_seed(test::test_seed(), 2, i));
        FrameInput input = test::static_input(scene);
        Pose pose = scene.sources[0].pose_at(0);
        pose.yaw_rad -= 1.5F * kMoves;
        for (int f = 0; f <= kMoves; ++f) {
            input.source_rotations[0] = pose.rotation();
            pose.yaw_rad += 1.5F;
            propagation.step(input);
        }
        read(propagation.response(0), figures);
    }
    return figures;
}

/// The largest distance between two sets of figures in standard errors.
double distance(const Figures& a, const Figures& b) {
    REQUIRE(a.size() == b.size());
    double largest = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        const test::Estimate x = test::estimate(a[i]);
        const test::Estimate y = test::estimate(b[i]);
        if (x.mean == 0 && y.mean == 0) continue;
        const double error = std::hypot(x.standard_error, y.standard_error);
        largest = std::max(largest, std::abs(x.mean - y.mean) / error);
    }
    return largest;
}

}  // namespace

TEST_CASE("rays from the listener give the same response and directions as rays from the source") {
    const Scene scene = colourful_room();
    const Figures forward = from_source(scene);
    CHECK(distance(forward, from_listener(scene)) < test::kFamilyZ);
    CHECK(distance(forward, from_listener(scene, 2)) < test::kFamilyZ);
    // Companion: a source half a metre away is distinguished from this one.
    Scene beside = scene;
    beside.sources[0].position += Vec3(0.5F, 0, 0);
    CHECK(distance(forward, from_listener(beside)) > test::kRefutedZ);
}

TEST_CASE("purely specular paths above the image sources' order are the same from either end") {
    Scene scene = colourful_room();
    scene.materials[0].scattering = Bands{};
    scene.simulation.rays = 4000;
    const Figures forward = from_source(scene);
    CHECK(distance(forward, from_listener(scene)) < test::kFamilyZ);
    Scene beside = scene;
    beside.sources[0].position += Vec3(0.5F, 0, 0);
    CHECK(distance(forward, from_listener(beside)) > test::kRefutedZ);
}

TEST_CASE("with a limited order both ends give the same response") {
    Scene scene = colourful_room();
    scene.simulation.order = 2;
    const Figures forward = from_source(scene);
    CHECK(distance(forward, from_listener(scene)) < test::kFamilyZ);
    scene.simulation.order = 3;
    CHECK(distance(forward, from_listener(scene)) > test::kRefutedZ);  // companion
}

TEST_CASE("a source with a directivity has the same response with rays from either end") {
    Scene scene = colourful_room();
    Source& source = scene.sources[0];
    source.directivity = *Directivity::find("loudspeaker");
    source.yaw_rad = 2;
    source.pitch_rad = -0.4F;
    const auto compare = [&] {
        const Figures forward = from_source(scene);
        CHECK(distance(forward, from_listener(scene)) < test::kFamilyZ);
        // A turn is a movement: the listener emits for a source that turns as well.
        CHECK(distance(forward, from_listener_for_turns(scene)) < test::kFamilyZ);
        // Companion: an omnidirectional source.
        Scene other = scene;
        other.sources[0].directivity = {};
        CHECK(distance(forward, from_listener(other)) > test::kRefutedZ);
    };
    SECTION("partly scattering walls") { compare(); }
    SECTION("purely specular paths above the image sources' order") {
        scene.materials[0].scattering = Bands{};
        scene.simulation.rays = 4000;
        compare();
    }
    SECTION("a limited order") {
        scene.simulation.order = 2;
        compare();
    }
}

TEST_CASE("the order is limited at partly specular surfaces as well") {
    // Plain path tracing counts reflections one by one.
    Scene scene = test::grey_room(test::box(Vec3(5, 4, 3)), 0.2F, 0.5F, Vec3(1.2F, 1.1F, 1.5F),
                                  Vec3(3.7F, 2.9F, 1.2F));
    scene.simulation.ir_length_s = 0.2F;
    scene.simulation.patch_size_m = 0.25F;
    const auto total = [](const EnergyResponse& r) { return r.total(0); };
    for (const int order : {1, 2, 3}) {
        scene.simulation.order = order;
        Simulation plain = scene.simulation;
        plain.estimator = Estimator::pt;
        plain.rays = 100000;
        Propagation reference(scene, plain);
        Propagation patch(scene, scene.simulation);
        const test::Estimate a = test::estimate(test::restarts(reference, scene, 24, 1, total));
        const test::Estimate b = test::estimate(test::restarts(patch, scene, 24, 5, total));
        const double error = std::hypot(a.standard_error, b.standard_error);
        CAPTURE(order, a.mean, b.mean, error);
        // The detection sphere averages over 0.5 m: up to 1 % at the onset.
        CHECK(std::abs(a.mean - b.mean) < test::kFamilyZ * error + 0.01 * a.mean);
        // Companion: a tenth more, as with the next order, is refuted.
        CHECK(std::abs(b.mean - 1.1 * a.mean) > test::kRefutedZ * error + 0.01 * a.mean);
    }
}

}  // namespace reciprocity_test
