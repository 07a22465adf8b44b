#include <catch2/catch.hpp>
#include <vector>

#include "aula/engine/propagation.h"
#include "tests/support/measure.h"
#include "tests/support/rooms.h"

using namespace aula;
using aula::test::with;

namespace {

Scene room_of_two_sources() {
    Scene scene = test::grey_room(test::box(Vec3(5, 4, 3)), 0.2F, 0.4F, Vec3(1.2F, 1.1F, 1.5F),
                                  Vec3(3.7F, 2.9F, 1.2F));
    scene.simulation.specular_order = 2;
    scene.simulation.direct = true;
    scene.sources.push_back(scene.sources[0]);
    scene.sources[1].position = Vec3(4, 1, 2);
    return scene;
}

/// All that responses hold.
struct Record {
    std::vector<Bands> energy;
    std::vector<DirectionMoments> directions;
    std::vector<Bands> paths;

    void add(const EnergyResponse& response) {
        energy.insert(energy.end(), response.energy.begin(), response.energy.end());
        directions.insert(directions.end(), response.directions.begin(), response.directions.end());
        for (const SoundPath& path : response.paths) paths.push_back(path.energy);
    }
    void add_all(const Propagation& propagation, std::size_t listeners) {
        for (std::size_t s = 0; s < propagation.source_count(); ++s)
            for (std::size_t l = 0; l < listeners; ++l) add(propagation.response(s, l));
    }
    friend bool operator==(const Record&, const Record&) = default;
};

}  // namespace

TEST_CASE("the same seed gives identical responses with one thread and with three") {
    for (const Estimator estimator :
         {Estimator::pt, Estimator::dpc_published, Estimator::dpc, Estimator::patch}) {
        const Scene scene = room_of_two_sources();
        std::vector<std::vector<EnergyResponse>> results;
        for (const int threads : {1, 3}) {
            Simulation simulation = with(scene, estimator, 0.2F, 0.2F);
            simulation.threads = threads;
            Propagation propagation(scene, simulation, 3);
            std::vector<EnergyResponse> responses;
            for (int f = 0; f < 8; ++f) {
                FrameInput input = test::static_input(scene);
                input.sources[0].x += 0.02F * static_cast<float>(f);
                input.listeners = {Vec3(3, 2, 1), Vec3(1, 3, 2), Vec3(2, 0.5F, 1)};
                input.listeners[1].y -= 0.05F * static_cast<float>(f);
                propagation.step(input);
            }
            // Six images of the first order and thirty of the second, of six pairs; two of each
            // higher order of flutter, up to the twelfth, between three pairs of walls.
            CHECK(propagation.statistics().image_reflections == 6 * (6 + 30 * 2 + 3 * 2 * 75));
            for (std::size_t s = 0; s < 2; ++s) {
                for (std::size_t l = 0; l < 3; ++l) {
                    responses.push_back(propagation.response(s, l));
                }
            }
            results.push_back(responses);
        }
        CAPTURE(estimator_name(estimator));
        for (std::size_t i = 0; i < results[0].size(); ++i) {
            CHECK(test::total(results[0][i]) > 0);
            CHECK(results[0][i].energy == results[1][i].energy);
            CHECK(results[0][i].directions == results[1][i].directions);
            REQUIRE(results[0][i].paths.size() == results[1][i].paths.size());
            for (std::size_t p = 0; p < results[0][i].paths.size(); ++p) {
                CHECK(results[0][i].paths[p].energy == results[1][i].paths[p].energy);
            }
        }
        CHECK_FALSE(results[0][0].energy == results[0][1].energy);  // companion
    }
}

TEST_CASE("responses are equal with any number of threads while sources come, rest, move and go") {
    const int specular_order = GENERATE(0, 2);
    const bool from_listeners = GENERATE(false, true);
    Scene scene = room_of_two_sources();
    scene.simulation.specular_order = specular_order;
    if (specular_order == 0) scene.materials[0].scattering = Bands::filled(1);
    std::vector<Record> records;
    for (const int threads : {1, 2, 5}) {
        Simulation simulation = with(scene, Estimator::patch, 0.2F, 0.2F);
        simulation.threads = threads;
        Propagation propagation(scene, simulation, 2);
        if (from_listeners) propagation.emit_from_listeners();
        FrameInput input = test::static_input(scene);
        input.source_rotations.clear();
        input.listeners = {Vec3(3, 2, 1), Vec3(1, 3, 2)};
        Record record;
        const auto step = [&](int frames, float source_m, float listener_m) {
            for (int f = 0; f < frames; ++f) {
                input.sources[0].x += source_m;
                input.listeners[1].y -= listener_m;
                propagation.step(input);
                record.add_all(propagation, input.listeners.size());
            }
        };
        step(4, 0.02F, 0);
        // At rest for more than a window: pairs are gathered in turn.
        step(simulation.window_frames() + 4, 0, 0);
        const std::vector<Vec3> receivers{Vec3(2, 2, 1), Vec3(4, 3, 2), Vec3(1, 0.5F, 1)};
        if (!from_listeners) {
            for (const EnergyResponse& response : propagation.responses_at(input, receivers))
                record.add(response);
        }
        Pose pose;
        pose.position = Vec3(2, 3, 1.5F);
        propagation.add_source(pose);
        input.sources.push_back(pose.position);
        step(3, 0, 0.03F);
        step(3, 0.02F, 0.03F);
        propagation.remove_source(1);
        input.sources.erase(input.sources.begin() + 1);
        step(3, 0, 0);
        records.push_back(record);
    }
    CHECK(records[0] == records[1]);
    CHECK(records[0] == records[2]);
    CHECK_FALSE(records[0].energy == std::vector<Bands>(records[0].energy.size()));  // companion
}
