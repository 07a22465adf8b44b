#include "apps/room/offline/interaural.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <vector>

#include "engine/response/octave_bank.h"
#include "tests/support/test_scenes.h"

namespace interaural_test {

namespace {

using namespace aula;

constexpr double kRate_hz = 48000;
const InterauralAnalysis kAnalysis(kRate_hz);

std::vector<float> noise(std::size_t count, unsigned seed) {
    std::mt19937 random(seed);
    std::normal_distribution<float> normal;
    std::vector<float> samples(count);
    for (float& x : samples) x = normal(random);
    return samples;
}

/// left + share * right, later by `delay` samples.
std::vector<float> mixed(const std::vector<float>& a, float share, const std::vector<float>& b,
                         std::size_t delay = 0) {
    std::vector<float> out(a.size());
    for (std::size_t n = delay; n < out.size(); ++n) out[n] = a[n - delay] + share * b[n - delay];
    return out;
}

}  // namespace

TEST_CASE("equal ears have the coefficient 1, also with delays up to 1 ms") {
    const auto left = noise(24000, 1);
    for (const std::size_t delay : {0U, 20U, 47U}) {
        INFO(delay << " samples");
        const auto bands = kAnalysis.parameters(left, mixed(left, 0, left, delay), 0.01);
        for (const InterauralParameters& band : bands) {
            // The delay moves 47 samples of 4320 over the limit of the early sound: 1 %, twice.
            CHECK(*band.early == Approx(1).margin(0.025));
            CHECK(*band.late == Approx(1).margin(0.025));
        }
    }
    // Companion: at 4 kHz a delay of 3 ms is beyond the limit.
    const auto late = kAnalysis.parameters(left, mixed(left, 0, left, 144), 0.01);
    CHECK(*late[6].late < 0.2);
}

TEST_CASE("early and late coefficients are those of their parts of the response") {
    auto left = noise(48000, 1);
    auto right = left;
    const auto other = noise(48000, 2);
    const double zero_s = 0.02;
    const auto limit = static_cast<std::size_t>(0.1 * kRate_hz);
    std::copy(other.begin() + static_cast<std::ptrdiff_t>(limit), other.end(),
              right.begin() + static_cast<std::ptrdiff_t>(limit));
    const auto bands = kAnalysis.parameters(left, right, zero_s);
    CHECK(*bands[4].early == Approx(1).margin(1e-6));
    // Independent noises: the largest of some ten independent values of 1 / sqrt(2 * 700 Hz * 0.9
    // s) = 0.03 each.
    CHECK(*bands[4].late < 0.12);
}

TEST_CASE("partly correlated ears have the coefficient of their common energy") {
    const auto left = noise(96000, 1);
    // Common energy 1 of 1 + 0.75^2: the correlation is 0.8.
    const auto right = mixed(left, 0.75F, noise(96000, 2));
    const auto bands = kAnalysis.parameters(left, right, 0.01);
    for (const std::size_t band : {3U, 4U, 5U, 6U}) {
        // Statistical: 350 Hz for 1.9 s, 0.36 / sqrt(1300) = 0.01; four of these.
        CHECK(*bands[band].late == Approx(0.8).margin(0.04));
        CHECK(*bands[band].late != Approx(0.7).margin(0.04));
    }
}

TEST_CASE("coefficients are those of octaves that are filtered and correlated sample by sample") {
    const auto left = noise(9000, 1);
    const auto right = mixed(left, 0.6F, noise(9000, 2), 13);
    const auto filtered = [](const std::vector<float>& signal) {
        std::vector<double> padded(signal.begin(), signal.end());
        padded.resize(signal.size() + static_cast<std::size_t>(0.3 * kRate_hz));
        return OctaveBank(kRate_hz).process(padded);
    };
    const auto l = filtered(left);
    const auto r = filtered(right);
    const auto bands = kAnalysis.parameters(left, right, 1);
    for (std::size_t b = 0; b < kBandCount; ++b) {
        double left_energy = 0;
        double right_energy = 0;
        for (const auto& x : l) left_energy += x[b] * x[b];
        for (const auto& x : r) right_energy += x[b] * x[b];
        double largest = 0;
        for (std::size_t delay = 0; delay <= 48; ++delay) {
            double later = 0;
            double earlier = 0;
            for (std::size_t n = delay; n < l.size(); ++n) {
                later += l[n - delay][b] * r[n][b];
                earlier += l[n][b] * r[n - delay][b];
            }
            largest = std::max({largest, std::abs(later), std::abs(earlier)});
        }
        INFO("band " << b);
        // Rounding of transforms in single precision, and the filters' decay after 0.3 s.
        CHECK(*bands[b].early ==
              Approx(largest / std::sqrt(left_energy * right_energy)).margin(1e-4));
    }
}

TEST_CASE("silent ears have no coefficient") {
    const std::vector<float> silence(24000);
    for (const InterauralParameters& band : kAnalysis.parameters(silence, noise(24000, 1), 0.01)) {
        CHECK_FALSE(band.early);
        CHECK_FALSE(band.late);
    }
}

TEST_CASE("a source in front is equal at both ears, reverberation is not") {
    Scene scene = test::small_room();
    scene.materials[0].absorption = Bands::filled(0.2F);
    scene.materials[0].scattering = Bands::filled(0.9F);
    // Within the critical distance. The head is turned to the source, whatever the pose of the
    // receiver.
    scene.sources[0].position = {3.1F, 2.9F, 1.2F};
    scene.listener.pose.yaw_rad = 1;
    const auto measured = measure(scene, {.frames = 20, .interaural = true});
    const PairParameters& p = measured->parameters[0];
    const auto value = [&](AcousticParameter parameter, std::size_t band) {
        return *p.octave(parameter, band).value;
    };
    using enum AcousticParameter;
    for (std::size_t band = 3; band < 7; ++band) {
        INFO("band " << band);
        // The direct sound is a part of the early sound only.
        CHECK(value(iacc_early, band) > value(iacc_late, band) + 0.1);
        // A diffuse field has a coefficient below 0.3 from 500 Hz on (Lindevald and Benade 1986).
        CHECK(value(iacc_late, band) < 0.35);
        CHECK(*p.octave(iacc_late, band).standard_error > 0);
        CHECK(*p.octave(iacc_late, band).standard_error < 0.1);
    }
    // The head is smaller than the wavelength.
    CHECK(value(iacc_late, 0) > 0.9);
    CHECK(*p.broadband[static_cast<std::size_t>(iacc_late)].value ==
          Approx((value(iacc_late, 3) + value(iacc_late, 4) + value(iacc_late, 5)) / 3));
    // Companion: without the option there are none.
    CHECK_FALSE(measure(scene, {.frames = 1})->parameters[0].octave(iacc_late, 4).value);

    // In free field only the asymmetry of the head's two ears remains.
    const auto open = measure(test::free_field({0, 3, 0}), {.frames = 1, .interaural = true});
    for (std::size_t band = 1; band < 6; ++band) {
        CHECK(*open->parameters[0].octave(iacc_early, band).value > 0.9);
        CHECK_FALSE(open->parameters[0].octave(iacc_late, band).value);
    }
}

TEST_CASE("a stop is seen between the interaural coefficients of receivers") {
    const Scene scene = test::small_room();
    const std::vector<Pose> receivers(9, scene.listener.pose);
    std::vector<double> shares;
    const auto stopped = measure(scene, scene.sources, receivers,
                                 {.frames = 1, .interaural = true, .progress = [&](double done) {
                                      shares.push_back(done);
                                      return shares.size() < 3;
                                  }});
    CHECK_FALSE(stopped);
    // The frame, then two pairs of source and receiver at a time.
    REQUIRE(shares.size() == 3);
    const double frame = shares[0];
    CHECK((frame > 0 && frame < 1));
    CHECK(shares[1] == Approx(frame + (1 - frame) * 2 / 9));
    CHECK(shares[2] == Approx(frame + (1 - frame) * 4 / 9));
}

TEST_CASE("interaural coefficients are part of the budget, and of the progress") {
    Scene scene = test::small_room();
    scene.simulation.rays = 100;
    std::vector<double> shares;
    const auto frames_of = [&](bool interaural) {
        shares.clear();
        const auto m = measure(scene, {.limits = {.level_db = 1e-6},
                                       .max_work_s = 0.3,
                                       .interaural = interaural,
                                       .progress = [&](double done) {
                                           shares.push_back(done);
                                           return true;
                                       }});
        CHECK(std::is_sorted(shares.begin(), shares.end()));
        CHECK(shares.back() == Approx(1));
        return m->frames;
    };
    const int alone = frames_of(false);
    const int with_coefficients = frames_of(true);
    CAPTURE(alone, with_coefficients);
    // They take a third of the budget, of windows of 8 frames.
    CHECK(with_coefficients < 0.9 * alone);
    CHECK(with_coefficients > 0.5 * alone - 8);
}

}  // namespace interaural_test
