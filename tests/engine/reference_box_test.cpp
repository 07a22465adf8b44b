#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>

#include "aula/engine/propagation.h"
#include "aula/engine/room_acoustics.h"
#include "aula/engine/scene_file.h"

namespace {

/// The mean of the responses of some frames.
aula::EnergyResponse mean_response(const aula::Scene& scene, int frames) {
    aula::Propagation propagation(scene, scene.simulation);
    const aula::FrameInput input{0, {scene.sources[0].position}, {scene.listener.pose.position}};
    aula::EnergyResponse mean;
    for (int f = 0; f < frames; ++f) {
        propagation.step(input);
        const aula::EnergyResponse& response = propagation.response(0);
        if (f == 0) {
            mean = response;
        } else {
            for (std::size_t i = 0; i < mean.energy.size(); ++i) {
                mean.energy[i] += response.energy[i];
            }
        }
    }
    for (aula::Bands& e : mean.energy) e *= 1 / static_cast<float>(frames);
    return mean;
}

}  // namespace

TEST_CASE("the reference box has its room-acoustic parameters") {
    const std::filesystem::path file =
        std::filesystem::path(AULA_SOURCE_DIR) / "scenes/reference/box_5x4x3.json";
    const aula::Scene scene = aula::load_scene(file).scene;
    const aula::RoomParameters parameters = aula::room_parameters(mean_response(scene, 40));
    const aula::BandParameters& p = parameters[4];
    // Statistical, fixed seed; six seeds spread by (standard deviation) 0.0006 s, 0.0006 s, 0.014
    // dB, 0.0006, 0.04 ms and 0.004 dB. Four of them, and 0.5% for the decay times, 0.02 dB for the
    // levels, because the reference is an independent numerical solution.
    CHECK(p.t30_s.value() == Approx(0.4811).margin(0.0048));
    CHECK(p.edt_s.value() == Approx(0.4828).margin(0.0048));
    CHECK(p.c80_db.value() == Approx(9.24).margin(0.08));
    CHECK(p.d50.value() == Approx(0.7484).margin(0.003));
    CHECK(p.ts_s.value() == Approx(0.0367).margin(0.0002));
    CHECK(p.g_db.value() == Approx(22.92).margin(0.035));
    // Companion: a Lambert box does not decay by Eyring's formula.
    const aula::Bands eyring_s =
        aula::eyring_time_s(4.0 * 60 / 94, scene.materials[0].absorption, aula::Bands{}, 343);
    CHECK(std::abs(p.t30_s.value() - double{eyring_s[4]}) > 0.0048);
    // All bands are equal here and share their rays.
    CHECK(parameters[0].t30_s.value() == Approx(p.t30_s.value()).epsilon(1e-4));
}
