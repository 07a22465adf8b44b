#include "audio/spatial/head_responses.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <vector>

#include "audio/spatial/hrtf.h"
#include "audio/spatial/sofa_file.h"
#include "tests/audio/convolution/signals.h"
#include "tests/audio/spatial/directions.h"

using namespace aula;
using namespace aula::test;

namespace {

constexpr std::size_t kSamples = 256;

/// The same response for every direction and ear.
HeadMeasurements measured(const std::vector<float>& response) {
    HeadMeasurements set;
    set.file = "set.sofa";
    set.samples = kSamples;
    set.positions = uniform_directions(50);
    for (std::size_t r = 0; r < 2 * set.positions.size(); ++r) {
        std::vector<float> padded = response;
        padded.resize(kSamples);
        set.responses.insert(set.responses.end(), padded.begin(), padded.end());
    }
    set.delays_samples.resize(2 * set.positions.size());
    return set;
}

/// Delay of an ear at +-y on a sphere (Woodworth 1938), in units of radius / speed of sound.
double woodworth(float towards_ear) {
    const double angle = std::acos(std::clamp(double{towards_ear}, -1.0, 1.0));
    return angle < std::numbers::pi / 2 ? -std::cos(angle) : angle - std::numbers::pi / 2;
}

HeadResponses sphere_head(const std::vector<Direction>& directions) {
    HeadResponses head;
    head.directions = directions;
    head.weights = quadrature_weights(directions);
    for (const auto& d : directions) {
        head.ears.push_back({Hrtf::Ear{{1}, woodworth(d[1])}, Hrtf::Ear{{1}, woodworth(-d[1])}});
    }
    return head;
}

}  // namespace

TEST_CASE("The earliest delay is 0 for either ear") {
    for (const std::size_t late : {0U, 1U}) {
        CAPTURE(late);
        HeadMeasurements set = measured({1});
        for (std::size_t r = late; r < set.delays_samples.size(); r += 2)
            set.delays_samples[r] = 40;
        const Hrtf hrtf(set, 48000);
        for (const auto& ears : hrtf.responses().ears) {
            // Exact except for the interpolation of the correlation's peak, equal for all.
            CHECK(ears[late].delay_s == Approx(40 / 48000.0).margin(1e-7));
            CHECK(ears[1 - late].delay_s == Approx(0).margin(1e-7));
        }
        const auto [first, second] = hrtf.ears({0.6F, 0, 0.8F});
        CHECK(std::min(first.delay_s, second.delay_s) >= 0);
    }
}

TEST_CASE("Equalisation raises frequencies without energy by at most 24 dB") {
    // A low-pass at 10 kHz, a sinc under a Blackman window: below -70 dB from 13 kHz on.
    std::vector<float> response;
    constexpr int kHalf = 48;
    for (int n = -kHalf; n <= kHalf; ++n) {
        const double x = std::numbers::pi * n / kHalf;
        const double window = 0.42 + 0.5 * std::cos(x) + 0.08 * std::cos(2 * x);
        const double step = 2 * std::numbers::pi * 10000 / 48000;
        const double sinc = n == 0 ? step : std::sin(step * n) / n;
        response.push_back(static_cast<float>(window * sinc / std::numbers::pi));
    }
    const Hrtf hrtf(measured(response), 48000);
    Signal padded = hrtf.ears({1, 0, 0})[0].minimum_phase;
    padded.resize(4096);
    const auto level_db = [&](double from_hz, double to_hz) {
        return 10 * std::log10(band_energy(padded, from_hz, to_hz, 48000) / (to_hz - from_hz));
    };
    const double raised_db = level_db(15000, 20000) - level_db(1000, 4000);
    CAPTURE(raised_db);
    // -70 dB + 24 dB; without the bound the spectrum would be flat.
    CHECK(raised_db < -40);
    // Companion: frequencies with energy are equalised.
    CHECK(level_db(6000, 8000) - level_db(1000, 4000) == Approx(0).margin(0.5));
}

TEST_CASE("The bound of the equalisation refers to the mean energy from 200 Hz to 8 kHz") {
    // A Hann window of 256 samples, with most of its energy below 200 Hz, and an impulse 65 dB
    // below the window's sum, which dominates from 6 kHz on.
    Signal response(kSamples);
    for (std::size_t n = 0; n < kSamples; ++n)
        response[n] = 0.5F - 0.5F * std::cos(2 * std::numbers::pi_v<float> * static_cast<float>(n) /
                                             float{kSamples});
    response[kSamples / 2] += 0.5F * float{kSamples} * std::pow(10.0F, -65.0F / 20);
    const Hrtf hrtf(measured(response), 48000);
    const auto level_db = [&](Signal signal, double from_hz, double to_hz) {
        signal.resize(16384);
        return 10 * std::log10(band_energy(signal, from_hz, to_hz, 48000) / (to_hz - from_hz));
    };
    const double raised_db =
        level_db(hrtf.ears({1, 0, 0})[0].minimum_phase, 6000, 16000) - level_db({1}, 6000, 16000);
    const double relative_db = level_db(response, 6000, 16000) - level_db(response, 200, 8000);
    CAPTURE(raised_db, relative_db);
    // The bins of the equalisation's transform are 23 Hz wide. Where the band begins the energy
    // falls to zero within seven of them: half of a bin is 1 dB.
    CHECK(raised_db == Approx(20 * std::log10(16) + relative_db).margin(1));
}

TEST_CASE("The delay of the head's centre does not depend on the density of directions") {
    const std::vector<Direction> even = uniform_directions(400);
    std::vector<Direction> dense = even;
    for (const auto& d : uniform_directions(20000)) {
        if (d[1] > 0.95F) dense.push_back(d);
    }
    REQUIRE(dense.size() > 2 * even.size());
    const double exact = sphere_head(even).centre_delay_s();
    const HeadResponses head = sphere_head(dense);
    // The weights are counted with 20000 points, 50 for each uniform direction: 1 %.
    CHECK(head.centre_delay_s() == Approx(exact).epsilon(0.02));
    // Companion: the unweighted mean differs.
    double mean = 0;
    for (const auto& ears : head.ears)
        mean += 0.5 * (ears[0].delay_s + ears[1].delay_s) / static_cast<double>(head.ears.size());
    CHECK(std::abs(mean / exact - 1) > 0.1);
}

TEST_CASE("Interpolated ears do not depend on the order of the measured directions") {
    HeadMeasurements set = measured({1});
    const std::size_t count = set.positions.size();
    // Each direction has a different delay.
    for (std::size_t r = 0; r < 2 * count; ++r)
        set.delays_samples[r] = static_cast<float>((r / 2 * 7) % 40 + r % 2);
    HeadMeasurements reversed = set;
    for (std::size_t i = 0; i < count; ++i) {
        reversed.positions[i] = set.positions[count - 1 - i];
        for (std::size_t e = 0; e < 2; ++e)
            reversed.delays_samples[2 * i + e] = set.delays_samples[2 * (count - 1 - i) + e];
    }
    const Hrtf one(set, 48000);
    const Hrtf other(reversed, 48000);
    for (const auto& direction : uniform_directions(37)) {
        const auto ears = one.ears(direction);
        const auto same = other.ears(direction);
        for (std::size_t e = 0; e < 2; ++e)
            CHECK(ears[e].delay_s == Approx(same[e].delay_s).margin(1e-7));  // rounding
    }
}

TEST_CASE("The quadrature weights of a regular solid are equal, and all weights sum to one") {
    const float a = 1 / std::sqrt(3.0F);
    const std::vector<Direction> octahedron{{1, 0, 0},  {-1, 0, 0}, {0, 1, 0},
                                            {0, -1, 0}, {0, 0, 1},  {0, 0, -1}};
    std::vector<Direction> cube;
    for (const float x : {a, -a})
        for (const float y : {a, -a})
            for (const float z : {a, -a}) cube.push_back({x, y, z});
    for (const auto& directions : {octahedron, cube}) {
        double sum = 0;
        for (const double weight : quadrature_weights(directions)) {
            sum += weight;
            // 20000 points of a lattice: the error is that of points at the cells' borders, about
            // the perimeter of a cell (5) over its area (2) and the distance of points (0.025)
            // / 50.
            CHECK(weight * static_cast<double>(directions.size()) == Approx(1).epsilon(0.01));
        }
        CHECK(sum == Approx(1));
    }
}

TEST_CASE("The weight of a direction is the share of the sphere nearest to it") {
    // Two opposite directions and one between: caps of 45 degrees and a zone.
    const std::vector<double> weights = quadrature_weights({{0, 0, 1}, {0, 0, -1}, {1, 0, 0}});
    // Without the third the poles would have halves. It takes points with x > |z|: a quarter of the
    // sphere, by symmetry of the planes x = z and x = -z.
    CHECK(weights[2] == Approx(0.25).margin(0.005));
    CHECK(weights[0] == Approx(0.375).margin(0.005));
    CHECK(weights[1] == Approx(0.375).margin(0.005));
    // A direction given twice counts once.
    const std::vector<double> twice = quadrature_weights({{0, 0, 1}, {0, 0, -1}, {0, 0, 1}});
    CHECK(twice[0] == Approx(0.5));
    CHECK(twice[2] == 0);
}

TEST_CASE("The last quarter of a response fades out, the rest is kept to the bit") {
    for (const std::size_t taps : {4U, 100U, 256U}) {
        std::vector<float> response(taps, 0.7F);
        fade_out(response);
        const std::size_t fade = taps / 4;
        CAPTURE(taps);
        for (std::size_t n = 0; n < taps - fade; ++n) CHECK(response[n] == 0.7F);
        for (std::size_t n = taps - fade; n < taps; ++n) {
            const double position = static_cast<double>(n - (taps - fade)) + 0.5;
            const double weight =
                0.5 + 0.5 * std::cos(std::numbers::pi * position / static_cast<double>(fade));
            CHECK(response[n] == Approx(0.7 * weight).margin(1e-7));  // rounding
        }
    }
    std::vector<float> short_one{1, 2, 3};
    fade_out(short_one);
    CHECK(short_one == std::vector<float>{1, 2, 3});
}
