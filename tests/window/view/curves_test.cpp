#include "apps/window/view/curves.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

using namespace aula;

namespace {

/// A decay of 60 dB a second in every band, with a direct sound at 10 ms.
EnergyResponse decaying() {
    EnergyResponse response = EnergyResponse::silent(TimeBins(1.0));
    for (std::size_t bin = 0; bin < response.bins.count(); ++bin) {
        const auto energy_to = [&](double time_s) { return std::pow(10.0, -6 * time_s); };
        response.energy[bin] = Bands::filled(static_cast<float>(
            energy_to(response.bins.begin_s(bin)) - energy_to(response.bins.end_s(bin))));
    }
    return response;
}

}  // namespace

TEST_CASE("A decay curve falls as the response does") {
    const auto curve = decay_curve_db(decaying(), 3, 0.01);
    CHECK(curve[0] == 0);
    // -30 dB at 0.5 s; the truncated rest is at -60 dB. Bins are 8 ms wide there, which is 0.5 dB.
    CHECK(static_cast<double>(curve[50]) == Approx(-30).margin(0.5));
    const auto all = decay_curve_db(decaying(), kAllBands, 0.01);
    CHECK(static_cast<double>(all[50]) == Approx(static_cast<double>(curve[50])).margin(1e-3));
}

TEST_CASE("An energy curve separates the binned energy from the discrete arrivals") {
    EnergyResponse response = decaying();
    SoundPath direct;
    direct.length_m = 3.432F;
    direct.energy = Bands::filled(0.5F);
    response.paths = {direct};
    const EnergyCurve curve = energy_curve(response, 2, 0.005);
    REQUIRE(curve.arrivals.size() == 1);
    CHECK(curve.arrivals[0].time_s == Approx(0.01));
    CHECK(static_cast<double>(curve.arrivals[0].level_db) == Approx(-3.01).margin(0.01));
    // The bins do not contain the arrival: they fall by 0.3 dB per step of 5 ms.
    CHECK(static_cast<double>(curve.diffuse_db[1] - curve.diffuse_db[3]) ==
          Approx(0.6).margin(0.05));
}

TEST_CASE("Frame noise is the relative standard deviation, restarted by a movement or a change") {
    std::mt19937 random(1);
    std::normal_distribution<float> deviation(1, 0.1F);
    FrameNoise noise;
    CHECK_FALSE(noise.relative(0));
    for (int frame = 0; frame < 24; ++frame) {
        // Independent factors per window of 20 ms, shared by the bins in a window.
        EnergyResponse response = decaying();
        std::vector<float> factors(64);
        for (float& factor : factors) factor = deviation(random);
        for (std::size_t bin = 0; bin < response.bins.count(); ++bin) {
            const auto window = static_cast<std::size_t>(response.bins.begin_s(bin) / 0.0200001);
            response.energy[bin] *= factors[window];
        }
        noise.add(response, Vec3(0), Vec3(1), 0);
    }
    // Statistical: 24 frames and about 7 windows give a standard error of 1/12; three of them.
    REQUIRE(noise.relative(0));
    CHECK(*noise.relative(0) == Approx(0.1).epsilon(0.25));
    CHECK(*noise.relative(kAllBands) == Approx(0.1).epsilon(0.25));
    noise.add(decaying(), Vec3(0), Vec3(2), 0);
    CHECK_FALSE(noise.relative(0));
    for (int frame = 0; frame < 10; ++frame) noise.add(decaying(), Vec3(0), Vec3(2), 0);
    CHECK(*noise.relative(0) == Approx(0).margin(1e-6));
    noise.add(decaying(), Vec3(0), Vec3(2), 1);
    CHECK_FALSE(noise.relative(0));
}
