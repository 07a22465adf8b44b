#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "aula/auralizer.h"
#include "tests/room/auralizer/auralizer_rendering.h"

using namespace aula;
using namespace aula::test;

namespace {

/// A free field with a source from which sound takes 291 ms, and a response of 100 ms.
Scene distant_source() {
    Scene scene = free_field({100, 0, 0});
    scene.simulation.ir_length_s = 0.1F;
    return scene;
}

constexpr double kDelay_s = 100 / 343.2;

float largest(std::span<const float> samples) {
    float peak = 0;
    for (const float x : samples) peak = std::max(peak, std::abs(x));
    return peak;
}

}  // namespace

TEST_CASE("The tail of a distant source contains its direct sound") {
    Auralizer auralizer(distant_source(), mono());
    // Before the first frame any path is possible.
    CHECK(auralizer.tail_samples() > 2 * 48000);
    rendered(auralizer, 4800, {480}, [](std::int64_t n) { return n == 4799 ? 1.0F : 0.0F; });
    const std::int64_t tail = auralizer.tail_samples();
    CHECK(static_cast<double>(tail) == Approx((kDelay_s + 0.1) * 48000).margin(480));
    const auto output = rendered(auralizer, tail, {480}, [](std::int64_t) { return 0.0F; });
    CHECK(largest(output) > 0.005F);
}

TEST_CASE("The direct sound of a distant source arrives after its removal") {
    Auralizer auralizer(distant_source(), mono());
    auralizer.remove_source(auralizer.sources()[0], 9001);
    const auto output =
        rendered(auralizer, 48000, {480}, [](std::int64_t n) { return n == 9000 ? 1.0F : 0.0F; });
    const auto arrival = static_cast<std::size_t>(9000 + kDelay_s * 48000) + 256;
    CHECK(largest(std::span(output).subspan(arrival - 500, 1000)) > 0.005F);
    // The source ends afterwards.
    CHECK(largest(std::span(output).subspan(arrival + 9600)) == 0);
}
