#include "audio/spatial/hrtf.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <thread>
#include <utility>
#include <vector>

#include "audio/dsp/fft.h"
#include "audio/spatial/head_responses.h"
#include "audio/spatial/sofa_file.h"
#include "tests/audio/convolution/signals.h"
#include "tests/audio/spatial/directions.h"
#include "tests/support/temporary_folder.h"

namespace hrtf_test {

using namespace aula;
using namespace aula::test;

namespace {

/// A head whose ears, at +y and -y, hear with level and delay that vary smoothly: 1 + 0.5 cos, and
/// 10 - 9 cos samples at 48 kHz, of the angle to the ear.
HeadMeasurements smooth_head(double rate_hz, std::size_t directions, float distance_m = 1) {
    HeadMeasurements head;
    head.file = "head.sofa";
    head.sample_rate_hz = static_cast<float>(rate_hz);
    head.samples = static_cast<std::size_t>(0.004 * rate_hz);
    for (const Direction& d : uniform_directions(directions)) {
        head.positions.push_back({distance_m * d[0], distance_m * d[1], distance_m * d[2]});
        for (const float side : {1.0F, -1.0F}) {
            std::vector<float> response(head.samples);
            response[0] = 1 + 0.5F * side * d[1];
            head.responses.insert(head.responses.end(), response.begin(), response.end());
            const double delay_s = (10 - 9 * double{side * d[1]}) / 48000;
            head.delays_samples.push_back(static_cast<float>(delay_s * rate_hz));
        }
    }
    return head;
}

double level_db(const std::vector<float>& response, double rate_hz) {
    Signal padded = response;
    padded.resize(8192);
    Signal impulse(8192);
    impulse[0] = 1;
    return 10 * std::log10(band_energy(padded, 500, 8000, rate_hz) /
                           band_energy(impulse, 500, 8000, rate_hz));
}

}  // namespace

TEST_CASE("At a measured direction the ears are those measured there") {
    const HeadMeasurements head = smooth_head(48000, 60);
    const Hrtf hrtf(head, 48000);
    const HeadResponses& responses = hrtf.responses();
    REQUIRE(responses.directions.size() == 60);
    for (std::size_t i = 0; i < 60; ++i) {
        const auto ears = hrtf.ears(responses.directions[i]);
        for (std::size_t e = 0; e < 2; ++e) {
            // Neighbours have weights of 1e-11.
            CHECK(ears[e].delay_s == Approx(responses.ears[i][e].delay_s).margin(1e-12));
            const auto& measured = responses.ears[i][e].minimum_phase;
            REQUIRE(ears[e].minimum_phase.size() == measured.size());
            for (std::size_t n = 0; n < measured.size(); ++n) {
                if (std::abs(ears[e].minimum_phase[n] - measured[n]) > 1e-6F)
                    FAIL("direction " << i << ", ear " << e << ", sample " << n);
            }
        }
    }
}

TEST_CASE("Between measured directions level and delay follow the head's") {
    const Hrtf hrtf(smooth_head(48000, 400), 48000);
    // Diffuse-field level: the mean of (1 + 0.5 cos)^2 is 1 + 0.25 / 3.
    const double diffuse_db = 10 * std::log10(1 + 0.25 / 3);
    for (const Direction& direction : uniform_directions(41)) {
        const auto ears = hrtf.ears(direction);
        CAPTURE(direction[0], direction[1], direction[2]);
        for (std::size_t e = 0; e < 2; ++e) {
            const double cosine = (e == 0 ? 1 : -1) * double{direction[1]};
            const double expected_db = 20 * std::log10(1 + 0.5 * cosine) - diffuse_db;
            // 400 directions are 0.19 rad apart: the nearest one errs by up to 0.11 rad, by 1
            // sample and 0.9 dB (at the quiet side). Interpolation halves it.
            CHECK(level_db(ears[e].minimum_phase, 48000) == Approx(expected_db).margin(0.45));
            CHECK(ears[e].delay_s * 48000 == Approx(9 - 9 * cosine).margin(0.5));
        }
    }
}

TEST_CASE("Ears change continuously where the nearest directions change") {
    const Hrtf hrtf(smooth_head(48000, 60), 48000);
    // Along a great circle in 4000 steps of 1.6 mrad.
    double largest = 0;
    double before = -1;
    for (int i = 0; i <= 4000; ++i) {
        const double angle = 2 * std::numbers::pi * i / 4000;
        const auto ears = hrtf.ears({static_cast<float>(0.8 * std::cos(angle)),
                                     static_cast<float>(std::sin(angle)),
                                     static_cast<float>(0.6 * std::cos(angle))});
        const double delay = ears[0].delay_s * 48000;
        if (i > 0) largest = std::max(largest, std::abs(delay - before));
        before = delay;
    }
    // 9 samples/rad x 1.6 mrad = 0.014; interpolation between coarse directions is up to ten times
    // as steep. A jump to another direction, 0.45 rad apart, would be 4 samples.
    CHECK(largest < 0.14);
    CHECK(largest > 0.007);
}

TEST_CASE("Responses and delays do not depend on the sample rates, nor on the distance") {
    const Hrtf reference(smooth_head(48000, 40), 48000);
    for (const auto& [from_hz, to_hz, distance_m] : {std::tuple{44100.0, 48000.0, 1.0F},
                                                     {48000.0, 44100.0, 1.0F},
                                                     {96000.0, 48000.0, 2.0F},
                                                     {48000.0, 96000.0, 0.3F},
                                                     {48000.0, 48000.0, 1.7F}}) {
        const Hrtf hrtf(smooth_head(from_hz, 40, distance_m), to_hz);
        CAPTURE(from_hz, to_hz, distance_m);
        CHECK(hrtf.taps() ==
              fast_fft_size(static_cast<std::size_t>(std::lround(256 * to_hz / 48000))));
        for (const Direction& direction : {Direction{1, 0, 0}, {0, 1, 0}, {0.6F, -0.64F, 0.48F}}) {
            const auto expected = reference.ears(direction);
            const auto ears = hrtf.ears(direction);
            for (std::size_t e = 0; e < 2; ++e) {
                // A hundredth of a sample, and the resampler's passband.
                CHECK(ears[e].delay_s * 48000 == Approx(expected[e].delay_s * 48000).margin(0.01));
                CHECK(level_db(ears[e].minimum_phase, to_hz) ==
                      Approx(level_db(expected[e].minimum_phase, 48000)).margin(0.02));
            }
        }
    }
}

TEST_CASE("The level of a measurement does not matter, the difference of its ears does") {
    const HeadMeasurements head = smooth_head(48000, 60);
    HeadMeasurements loud = head;
    for (float& x : loud.responses) x *= 300;
    HeadMeasurements lopsided = head;
    for (std::size_t r = 1; r < 120; r += 2) lopsided.responses[r * head.samples] *= 0.5F;
    const auto expected = Hrtf(head, 48000).ears({1, 0, 0});
    const auto same = Hrtf(loud, 48000).ears({1, 0, 0});
    const auto other = Hrtf(lopsided, 48000).ears({1, 0, 0});
    for (std::size_t e = 0; e < 2; ++e) {
        CHECK(level_db(same[e].minimum_phase, 48000) ==
              Approx(level_db(expected[e].minimum_phase, 48000)).margin(1e-3));
    }
    const double difference_db =
        level_db(other[0].minimum_phase, 48000) - level_db(other[1].minimum_phase, 48000);
    const double before_db =
        level_db(expected[0].minimum_phase, 48000) - level_db(expected[1].minimum_phase, 48000);
    CHECK(difference_db - before_db == Approx(20 * std::log10(2)).margin(1e-3));
}

TEST_CASE("Four directions suffice") {
    HeadMeasurements head = smooth_head(48000, 4);
    const float a = 1 / std::sqrt(3.0F);
    head.positions = {{a, a, a}, {a, -a, -a}, {-a, a, -a}, {-a, -a, a}};
    const Hrtf hrtf(head, 48000);
    for (const double weight : hrtf.responses().weights)
        CHECK(weight == Approx(0.25).margin(0.002));  // of 20000 points, as below
    double greatest_s = 0;
    for (const auto& ears : hrtf.responses().ears)
        for (const Hrtf::Ear& ear : ears) greatest_s = std::max(greatest_s, ear.delay_s);
    for (const Direction& direction : uniform_directions(50)) {
        for (const Hrtf::Ear& ear : hrtf.ears(direction)) {
            // A mean of measured delays.
            CHECK(ear.delay_s >= 0);
            CHECK(ear.delay_s <= greatest_s * (1 + 1e-6));
            CHECK(std::isfinite(level_db(ear.minimum_phase, 48000)));
        }
    }
    // Opposite a direction the three others are equally near.
    const auto between = hrtf.ears({-a, -a, -a});
    for (std::size_t e = 0; e < 2; ++e) {
        double mean_s = 0;
        for (std::size_t i = 1; i < 4; ++i) mean_s += hrtf.responses().ears[i][e].delay_s / 3;
        CHECK(between[e].delay_s == Approx(mean_s).epsilon(1e-4));
    }
}

TEST_CASE("Responses that end at their loudest sample keep their level at other rates") {
    const auto levels = [](std::size_t sample) {
        HeadMeasurements head = smooth_head(44100, 20);
        // A few: what all responses have in common is equalised.
        for (std::size_t r = 0; r < 4; ++r) {
            float* const response = head.responses.data() + r * head.samples;
            std::swap(response[0], response[sample]);
        }
        const Hrtf hrtf(head, 48000);
        std::vector<double> levels_db;
        for (const auto& ears : hrtf.responses().ears)
            for (const Hrtf::Ear& ear : ears)
                levels_db.push_back(level_db(ear.minimum_phase, 48000));
        return levels_db;
    };
    const std::vector<double> in_the_middle = levels(80);
    const std::vector<double> at_the_end = levels(175);
    for (std::size_t i = 0; i < in_the_middle.size(); ++i)
        CHECK(at_the_end[i] == Approx(in_the_middle[i]).margin(0.02));
}

TEST_CASE("Long minimum-phase responses are recovered to their last tap") {
    // Zeros at radius 0.995 at 0 Hz and at the Nyquist frequency, one of each at the two ears: the
    // mean energy of the ears is the same at all frequencies. The cepstrum decays as 0.995^n / n.
    constexpr float kRadius = 0.995F;
    HeadMeasurements head = smooth_head(48000, 40);
    std::fill(head.delays_samples.begin(), head.delays_samples.end(), 0.0F);
    for (std::size_t r = 0; r < 80; ++r) {
        head.responses[r * head.samples] = 1;
        head.responses[r * head.samples + 1] = r % 2 == 0 ? kRadius : -kRadius;
    }
    const auto ears = Hrtf(head, 48000).ears({0.6F, 0.64F, 0.48F});
    const double scale = 1 / std::sqrt(1 + double{kRadius} * double{kRadius});
    for (std::size_t e = 0; e < 2; ++e) {
        const std::vector<float>& taps = ears[e].minimum_phase;
        const double second = (e == 0 ? 1 : -1) * double{kRadius} * scale;
        // A transform of four times the length aliases the cepstrum by 0.995^1024 / 1024 = 6e-6,
        // one of the same length by 1e-3.
        CHECK(double{taps[0]} == Approx(scale).margin(5e-5));
        CHECK(double{taps[1]} == Approx(second).margin(5e-5));
        for (std::size_t n = 2; n < taps.size(); ++n)
            if (std::abs(taps[n]) > 5e-5F) FAIL("ear " << e << ", tap " << n << ": " << taps[n]);
    }
}

TEST_CASE("Users of one file at one rate share its HRTF until the file changes") {
    namespace fs = std::filesystem;
    const TemporaryFolder folder;
    const fs::path file = folder.path() / "head.sofa";
    fs::copy_file("/usr/share/libmysofa/default.sofa", file);
    auto first = load_hrtf(file, 48000);
    CHECK(load_hrtf(file, 48000) == first);
    CHECK(load_hrtf(folder.path() / "." / "head.sofa", 48000) == first);
    CHECK(load_hrtf(file, 44100) != first);
    fs::last_write_time(file, fs::last_write_time(file) + std::chrono::seconds(1));
    CHECK(load_hrtf(file, 48000) != first);
    // Nothing keeps it after its last user.
    const std::weak_ptr<const Hrtf> gone = load_hrtf(file, 48000);
    CHECK(gone.expired());
    // Threads that ask for it at the same time get one object.
    std::vector<std::shared_ptr<const Hrtf>> found(4);
    std::vector<std::thread> threads;
    for (auto& hrtf : found) threads.emplace_back([&] { hrtf = load_hrtf("", 48000); });
    for (std::thread& thread : threads) thread.join();
    for (const auto& hrtf : found) CHECK(hrtf == found[0]);
}

}  // namespace hrtf_test
