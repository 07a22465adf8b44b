#include "apps/window/model/curves.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

using namespace aula;

namespace {

/// A decay of 60 dB a second in every band, with a direct sound at 10 ms.
EnergyResponse decaying() {
    EnergyResponse response;
    response.bins = TimeBins(1.0);
    for (std::size_t bin = 0; bin < response.bins.count(); ++bin) {
        const auto energy_to = [&](double time_s) { return std::pow(10.0, -6 * time_s); };
        response.energy.push_back(Bands::filled(static_cast<float>(
            energy_to(response.bins.begin_s(bin)) - energy_to(response.bins.end_s(bin)))));
        response.direction.push_back(Vec3(0));
    }
    return response;
}

}  // namespace

TEST_CASE("A decay curve falls as the response does") {
    const auto curve = decay_curve_db(decaying(), 3, 0.01);
    CHECK(curve[0] == 0);
    // Half a second is -30 dB; what lies behind the end is -60 dB. Bins are 8 ms wide there, 0.5
    // dB.
    CHECK(static_cast<double>(curve[50]) == Approx(-30).margin(0.5));
    const auto all = decay_curve_db(decaying(), kAllBands, 0.01);
    CHECK(static_cast<double>(all[50]) == Approx(static_cast<double>(curve[50])).margin(1e-3));
}

TEST_CASE("An energy curve parts what is binned from what arrives one by one") {
    EnergyResponse response = decaying();
    SpecularPath direct;
    direct.length_m = 3.432F;
    direct.energy = Bands::filled(0.5F);
    response.paths = {direct};
    const EnergyCurve curve = energy_curve(response, 2, 0.005);
    REQUIRE(curve.arrows.size() == 1);
    CHECK(curve.arrows[0].time_s == Approx(0.01));
    CHECK(static_cast<double>(curve.arrows[0].level_db) == Approx(-3.01).margin(0.01));
    // The arrival is not in the bins: they fall evenly by 0.3 dB a step of 5 ms.
    CHECK(static_cast<double>(curve.diffuse_db[1] - curve.diffuse_db[3]) ==
          Approx(0.6).margin(0.05));
}

TEST_CASE("Frame noise is the deviation over the mean; what moves or changes begins anew") {
    std::mt19937 random(1);
    std::normal_distribution<float> deviation(1, 0.1F);
    FrameNoise noise;
    CHECK_FALSE(noise.relative(0));
    for (int frame = 0; frame < 24; ++frame) {
        // In windows of 20 ms, each by itself: bins that lie in one share its factor.
        EnergyResponse response = decaying();
        std::vector<float> factors(64);
        for (float& factor : factors) factor = deviation(random);
        for (std::size_t bin = 0; bin < response.bins.count(); ++bin) {
            const auto window = static_cast<std::size_t>(response.bins.begin_s(bin) / 0.0200001);
            response.energy[bin] *= factors[window];
        }
        noise.add(response, Vec3(0), Vec3(1), 0);
    }
    // 24 frames and some 7 windows that count: a standard error of about a twelfth; three of them.
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
