#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "aula/engine/propagation.h"
#include "tests/support/measure.h"
#include "tests/support/rooms.h"

using namespace aula;

namespace {

constexpr Vec3 kSource(2, 2, 1.5F);
constexpr Vec3 kListener(7, 6, 1.6F);

/// A hall with a partition that leaves 2 of its 8 m open.
Scene divided_hall(float scattering) {
    Scene scene = test::grey_room(test::box(Vec3(10, 8, 3)), 0.2F, scattering, kSource, kListener);
    scene.objects.push_back(test::box(Vec3(0.1F, 6, 3), 0, Vec3(4.95F, 0, 0)));
    return scene;
}

FrameInput walk(const Scene& scene, int frame) {
    FrameInput input = test::static_input(scene);
    const float way_m = 0.03F * static_cast<float>(frame);
    for (Vec3& source : input.sources) source += Vec3(0, way_m, 0);
    input.listeners[0] -= Vec3(0, way_m, 0);
    return input;
}

/// The energies of bands from 50 to 400 ms in parts of about 20 ms, over all parts.
double error(const EnergyResponse& walked, const EnergyResponse& rested) {
    double squares = 0;
    int parts = 0;
    for (double begin_s = 0.05; begin_s < 0.39; begin_s += 0.02, ++parts) {
        const double wanted = test::energy_between(rested, begin_s, begin_s + 0.02, 3);
        const double got = test::energy_between(walked, begin_s, begin_s + 0.02, 3);
        squares += std::pow(got / wanted - 1, 2);
    }
    return std::sqrt(squares / parts);
}

/// The response of a place of a walk, from a long rest.
EnergyResponse at_rest(const Scene& scene, const FrameInput& place) {
    Propagation propagation(scene, test::with(scene, Estimator::patch, 0.5F));
    for (int frame = 0; frame < 100; ++frame) propagation.step(place);
    return propagation.response(0);
}

}  // namespace

TEST_CASE("While both ends walk the response has the energies of a rest at each place") {
    for (const float scattering : {1.0F, 0.4F}) {
        CAPTURE(scattering);
        const Scene scene = divided_hall(scattering);
        Propagation propagation(scene, test::with(scene, Estimator::patch, 0.5F));
        for (int frame = 0; frame <= 90; ++frame) {
            propagation.step(walk(scene, frame));
            if (frame < 45 || frame % 15 != 0) continue;
            CAPTURE(frame);
            const EnergyResponse rested = at_rest(scene, walk(scene, frame));
            const EnergyResponse& walked = propagation.response(0);
            const double difference = error(walked, rested);
            WARN("both walk: error of 20 ms "
                 << 100 * difference << " %, level "
                 << 10 * std::log10(test::energy_between(walked, 0.05, 0.4, 3) /
                                    test::energy_between(rested, 0.05, 0.4, 3))
                 << " dB");
            // Rays of one frame have an error of 7 %, and their mean over a window lags.
            CHECK(difference < 0.03);
        }
    }
}

TEST_CASE("After a jump of both ends the first response is that of the new places") {
    const Scene scene = divided_hall(1);
    Propagation propagation(scene, test::with(scene, Estimator::patch, 0.5F));
    for (int frame = 0; frame <= 60; ++frame) propagation.step(walk(scene, frame));
    FrameInput place = test::static_input(scene);
    place.sources[0] = Vec3(8, 2, 1.5F);
    place.listeners[0] = Vec3(6, 3, 1.7F);
    propagation.step(place);
    CHECK(error(propagation.response(0), at_rest(scene, place)) < 0.04);
}

TEST_CASE("Sound that is predicted arrives from the directions of sound that is traced") {
    // Of two sources that walk with the listener, the listener emits; of one, the source does.
    Scene scene = test::grey_room(test::box(Vec3(10, 4, 3)), 0.1F, 1, kSource, Vec3(7, 2, 1.6F));
    scene.materials.push_back(scene.materials[0]);
    scene.materials[1].absorption = Bands::filled(0.9F);
    Object& room = scene.objects[0];
    for (std::size_t t = 0; t < room.triangles.size(); ++t) {
        const auto& corners = room.triangles[t];
        if (std::all_of(corners.begin(), corners.end(),
                        [&](std::uint32_t v) { return room.vertices[v].x > 9.9F; }))
            room.triangle_materials[t] = 1;
    }
    for (const std::size_t sources : {1U, 2U}) {
        CAPTURE(sources);
        scene.sources.resize(sources, scene.sources[0]);
        const Simulation simulation = test::with(scene, Estimator::patch, 0.5F, 0.5F);
        Propagation propagation(scene, simulation);
        for (int frame = 0; frame <= 60; ++frame) propagation.step(walk(scene, frame));
        Propagation rest(scene, simulation);
        for (int frame = 0; frame < 100; ++frame) rest.step(walk(scene, 60));
        const auto flow = [](const EnergyResponse& response) {
            double x = 0;
            double energy = 0;
            for (std::size_t k = response.bins.index(0.1); k < response.bins.index(0.3); ++k) {
                x += double{response.directions[k].intensity.x};
                energy += double{response.energy[k].sum()};
            }
            return x / energy;
        };
        // The sound flows to the wall that absorbs.
        const double wanted = flow(rest.response(0));
        CHECK(wanted < -0.1);
        CHECK(flow(propagation.response(0)) == Approx(wanted).margin(0.03));
    }
}

TEST_CASE("A walk of both ends is the same with one thread and with three") {
    const Scene scene = divided_hall(0.5F);
    std::vector<EnergyResponse> responses;
    for (const int threads : {1, 3}) {
        Simulation simulation = test::with(scene, Estimator::patch, 0.5F);
        simulation.threads = threads;
        Propagation propagation(scene, simulation);
        for (int frame = 0; frame < 12; ++frame) propagation.step(walk(scene, frame));
        responses.push_back(propagation.response(0));
    }
    CHECK(test::same_bits(responses[0], responses[1]));
}
