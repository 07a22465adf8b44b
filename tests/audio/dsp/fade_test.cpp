#include "audio/dsp/fade.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

using namespace aula;

TEST_CASE("Fade-in and fade-out weights sum to one in any blocks") {
    constexpr std::size_t kFade = 100;
    Fade fade(kFade);
    CHECK(fade.done());
    fade.start();
    std::vector<float> in(150, 1.0F);
    std::vector<float> out(150, 1.0F);
    for (std::size_t done = 0; done < in.size(); done += 30) {
        fade.fade_in(std::span(in).subspan(done, 30));
        fade.fade_out(std::span(out).subspan(done, 30));
        fade.advance(30);
    }
    CHECK(fade.done());
    CHECK(in.front() > 0);
    CHECK(in.front() < 1e-3F);
    for (std::size_t i = 0; i < in.size(); ++i) {
        // Rounding: one subtraction.
        CHECK(double{in[i] + out[i]} == Approx(1).margin(1e-7));
        if (i > 0) CHECK(in[i] >= in[i - 1]);
        if (i >= kFade) CHECK(in[i] == 1);
    }
}

TEST_CASE("Fades on rounded lines in sequence keep what rises steadily on a line") {
    const std::vector<float> weights = rounded_line(1600);
    for (std::size_t n = 0; n < 1600; ++n) {
        CHECK(double{weights[n] + weights[1599 - n]} == Approx(1).margin(1e-6));
        // The line of a staircase of such fades, and its corners.
        const double line = (static_cast<double>(n) + 0.5) / 1600;
        CHECK(double{weights[n]} == Approx(line).margin(0.0101));
        // Companion: a raised cosine is off the line by a tenth.
        if (n == 300) CHECK(std::abs(double{raised_cosine(1600)[n]} - line) > 0.09);
    }
    CHECK(weights[0] < 1e-4F);
    CHECK(std::is_sorted(weights.begin(), weights.end()));
}

TEST_CASE("All channels fade in with the same weights in any blocks") {
    constexpr std::size_t kFade = 100;
    Fade fade(kFade);
    std::vector<float> expected(120, 0.5F);
    fade.start();
    fade.fade_in(expected);
    std::vector<std::vector<float>> channels(3, std::vector<float>(120, 0.5F));
    for (std::size_t done = 0; done < expected.size(); done += 30) {
        CHECK_FALSE(fade.done());
        const std::array<float*, 3> block{channels[0].data() + done, channels[1].data() + done,
                                          channels[2].data() + done};
        fade.fade_in_next(block, 30);
    }
    CHECK(fade.done());
    for (const std::vector<float>& channel : channels) CHECK(channel == expected);
    CHECK(expected[99] < 0.5F);
    CHECK(expected[100] == 0.5F);
}

TEST_CASE("A reversed fade continues from its present weight") {
    Fade fade(100);
    fade.start();
    fade.advance(30);
    const float before = fade.weight(0);
    fade.reverse();
    // At most one step of the curve: pi / 200 at the steepest point.
    CHECK(double{1 - fade.weight(0)} == Approx(double{before}).margin(0.016));
    fade.advance(30);
    CHECK(fade.done());
}

TEST_CASE("A crossfade between equal signals changes nothing") {
    Fade fade(64);
    fade.start();
    const std::vector<float> old(64, 0.7F);
    std::vector<float> samples = old;
    fade.cross(old, samples);
    CHECK(samples == old);
}
