#include "apps/room/images/box_images.h"

#include <algorithm>
#include <array>
#include <bit>
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/support/test_scenes.h"

namespace box_images_test {

using namespace aula;
using namespace aula::test;

namespace {

/// The response of a box of absorption 0.2, and `octave_8k` in the octave of 8 kHz.
EnergyResponse response_of(float octave_8k) {
    Scene scene = small_room();
    scene.materials[0].absorption = Bands::filled(0.2F);
    scene.materials[0].absorption[7] = octave_8k;
    scene.materials[0].scattering = Bands{};
    scene.simulation.specular_order = 1;
    const std::array<Pose, 1> receivers{scene.listener.pose};
    const auto images = BoxImages::find(scene, receivers, 0.2);
    REQUIRE(images);
    return images->response(0, 0);
}

}  // namespace

TEST_CASE("Image sources of equal octaves have the energies and directions of those of others") {
    // Equal octaves are summed in milliseconds, others image by image: the directions of a bin
    // differ by those of single images at its edges, which have other times.
    const EnergyResponse flat = response_of(0.2F);
    const EnergyResponse other = response_of(0.2001F);
    REQUIRE(flat.paths.size() == other.paths.size());
    for (std::size_t bin = 0; bin < flat.bins.count(); ++bin) {
        const float energy = flat.energy[bin].sum();
        CAPTURE(bin);
        CHECK(other.energy[bin].sum() == Approx(energy).epsilon(1e-3));
        if (energy == 0) continue;
        using Floats = std::array<float, 8>;
        const auto a = std::bit_cast<Floats>(flat.directions[bin] / energy);
        const auto b = std::bit_cast<Floats>(other.directions[bin] / energy);
        for (std::size_t i = 0; i < a.size(); ++i) CHECK(std::abs(a[i] - b[i]) < 1e-3F);
    }
    // Companion: a bin of few images is far from diffuse.
    const auto directed = [&](std::size_t bin) {
        return std::abs(flat.directions[bin].xx) > 0.1F * flat.energy[bin].sum();
    };
    bool any = false;
    for (std::size_t bin = 0; bin < 40; ++bin) any = any || directed(bin);
    CHECK(any);
}

}  // namespace box_images_test
