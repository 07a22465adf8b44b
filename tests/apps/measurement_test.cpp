#include "apps/session/measurement.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "engine/propagation.h"
#include "engine/room_acoustics.h"
#include "tests/support/octave.h"
#include "tests/support/test_scenes.h"

namespace {

using namespace aula;
using test::free_field;
using test::small_room;

/// T30 of a band of an impulse response: the slope of Schroeder's curve from -5 to -35 dB.
double decay_time_s(const std::vector<float>& response, double centre_hz, double rate_hz) {
    const auto band = test::octave(response, centre_hz, rate_hz);
    std::vector<double> energy(band.size() + 1);
    for (std::size_t i = band.size(); i-- > 0;) energy[i] = energy[i + 1] + band[i] * band[i];
    double n = 0, t_sum = 0, level_sum = 0, tt_sum = 0, t_level_sum = 0;
    for (std::size_t i = 0; i < band.size(); ++i) {
        const double level_db = 10 * std::log10(energy[i] / energy[0]);
        if (level_db > -5 || level_db < -35) continue;
        const double t = static_cast<double>(i) / rate_hz;
        n += 1;
        t_sum += t;
        level_sum += level_db;
        tt_sum += t * t;
        t_level_sum += t * level_db;
    }
    const double slope_db_s = (n * t_level_sum - t_sum * level_sum) / (n * tt_sum - t_sum * t_sum);
    return -60 / slope_db_s;
}

double level_db(const EnergyResponse& response, std::size_t band) {
    return 10 * std::log10(response.total(band));
}

}  // namespace

TEST_CASE("N frames give the mean of the N responses that propagation publishes") {
    Scene scene = small_room();
    scene.simulation.rays = 50;
    constexpr int kFrames = 5;
    Propagation propagation(scene, scene.simulation);
    const FrameInput input{.sources = {scene.sources[0].position},
                           .listeners = {scene.listener.pose.position}};
    std::vector<double> sum;
    for (int frame = 0; frame < kFrames; ++frame) {
        propagation.step(input);
        const auto uniform = propagation.response(0).uniform(1e-3);
        sum.resize(uniform.size());
        for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += static_cast<double>(uniform[i][4]);
    }
    const auto measurement = measure(scene, kFrames);
    REQUIRE(measurement);
    REQUIRE(measurement->frames == kFrames);
    const auto mean = measurement->responses[0].uniform(1e-3);
    REQUIRE(mean.size() == sum.size());
    // Rounding of single precision: the mean is rounded once, each response a few times.
    for (std::size_t i = 0; i < sum.size(); ++i)
        REQUIRE(static_cast<double>(mean[i][4]) == Approx(sum[i] / kFrames).epsilon(1e-5));
}

TEST_CASE("Without N the level of every octave is as good as promised, whatever the seed") {
    Scene scene = small_room();
    scene.simulation.rays = 50;
    const auto one = measure(scene, {});
    scene.simulation.seed = 2;
    const auto two = measure(scene, {});
    REQUIRE(one);
    REQUIRE(one->frames >= 8 * scene.simulation.window_frames());
    REQUIRE(one->frames < 2000);
    for (std::size_t band = 0; band < kBandCount; ++band) {
        // Statistical: each level has a standard error of at most 0.1 dB, their difference of
        // 0.14 dB; four of these.
        CHECK(level_db(one->responses[0], band) ==
              Approx(level_db(two->responses[0], band)).margin(0.57));
    }
    // The companion: a wall that absorbs a third less is told apart.
    scene.materials[0].absorption = Bands::filled(0.2F);
    const auto louder = measure(scene, {});
    CHECK(level_db(louder->responses[0], 4) != Approx(level_db(two->responses[0], 4)).margin(0.57));
}

TEST_CASE("A measurement stops when it is asked to") {
    int asked = 0;
    REQUIRE_FALSE(measure(small_room(), 100, [&](double) { return ++asked < 3; }));
    REQUIRE(asked == 3);
}

TEST_CASE("What comes from the left is positive in Y, zero in X, and louder in the left ear") {
    Scene scene = free_field({0, 3.432F, 0});
    const auto measurement = measure(scene, 1);
    SessionOptions options;
    options.output = OutputFormat::foa;
    const auto foa = impulse_response(scene, 0, *measurement, options, nullptr);
    REQUIRE(foa.size() == 4);
    const auto at = [&](std::size_t channel) { return static_cast<double>(foa[channel][480]); };
    // SN3D: Y is W for sound from y. 0.1 dB: rounding in the design of the filters.
    CHECK(at(0) == Approx(1 / 3.432).epsilon(0.0116));
    CHECK(at(1) == Approx(at(0)).epsilon(1e-4));
    CHECK(at(2) == Approx(0).margin(1e-4));
    CHECK(at(3) == Approx(0).margin(1e-4));

    options.output = OutputFormat::binaural;
    const auto ears = impulse_response(scene, 0, *measurement, options,
                                       hrtf_for(options, options.sample_rate_hz));
    double energy[2] = {0, 0};
    for (std::size_t ear = 0; ear < 2; ++ear)
        for (const float x : ears[ear])
            energy[ear] += static_cast<double>(x) * static_cast<double>(x);
    // A head shades the far ear by some 10 dB over the whole spectrum; 6 dB is clear of it.
    CHECK(energy[0] > 4 * energy[1]);
}

TEST_CASE("A head that turns towards a source has it in front") {
    Scene scene = free_field({0, 3.432F, 0});
    scene.listener.pose.yaw_rad = 1.5707963F;
    const auto measurement = measure(scene, 1);
    SessionOptions options;
    options.output = OutputFormat::foa;
    const auto foa = impulse_response(scene, 0, *measurement, options, nullptr);
    CHECK(static_cast<double>(foa[3][480]) == Approx(1 / 3.432).epsilon(0.0116));
    CHECK(static_cast<double>(foa[1][480]) == Approx(0).margin(1e-4));
}

TEST_CASE("The impulse response decays as the report says") {
    Scene scene = test::small_room();
    scene.materials[0].absorption = Bands::filled(0.1F);
    scene.simulation.rays = 200;
    scene.simulation.ir_length_s = 1.5F;
    SessionOptions options;
    options.output = OutputFormat::mono;
    constexpr int kSeeds = 4;
    for (const std::size_t band : {4U, 5U, 6U}) {
        const auto centre_hz = static_cast<double>(kBandCentres_hz[band]);
        double heard_s = 0;
        double reported_s = 0;
        for (int seed = 1; seed <= kSeeds; ++seed) {
            scene.simulation.seed = static_cast<std::uint64_t>(seed);
            const auto measurement = measure(scene, 5);
            const auto response = impulse_response(scene, 0, *measurement, options, nullptr);
            heard_s += decay_time_s(response[0], centre_hz, options.sample_rate_hz) / kSeeds;
            reported_s += *room_parameters(measurement->responses[0])[band].t30_s / kSeeds;
        }
        INFO(centre_hz << " Hz: " << heard_s << " s heard, " << reported_s << " s reported");
        // Statistical: a decay of T = 0.9 s of noise of bandwidth B has a T30 with the relative
        // standard error of about 0.6 / sqrt(B T), 2.4 % at 1 kHz, half of that for four seeds;
        // 5 % is four of these, and a listener's just noticeable difference.
        CHECK(heard_s == Approx(reported_s).epsilon(0.05));
        // The companion: walls that absorb a tenth more are told apart.
        CHECK(heard_s != Approx(reported_s / 1.1).epsilon(0.05));
    }
}
