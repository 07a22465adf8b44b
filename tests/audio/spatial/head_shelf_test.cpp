#include "audio/spatial/head_shelf.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <vector>

#include "tests/audio/player.h"
#include "tests/audio/spatial/rigid_sphere.h"

using namespace aula;
using namespace aula::test;

namespace {

constexpr double kReference_m = 1.4;

double level_db(const std::vector<float>& response, double frequency_hz) {
    std::complex<double> sum = 0;
    for (std::size_t n = 0; n < response.size(); ++n)
        sum += double{response[n]} * std::polar(1.0, -2 * std::numbers::pi * frequency_hz *
                                                         static_cast<double>(n) / kRate_hz);
    return 20 * std::log10(std::abs(sum));
}

double shelf_db(const HeadShelf& shelf, double frequency_hz) {
    std::vector<float> response(256);
    response[0] = 1;
    shelf.apply(kRate_hz, response);
    return level_db(response, frequency_hz);
}

/// Ears of KEMAR for direct sound from the left at a distance, [ear]: level at a frequency, dB re
/// the free field.
std::array<double, 2> ears_db(float distance_m, double frequency_hz, float distinctness = 1) {
    static const auto hrtf = std::make_shared<const Hrtf>("", kRate_hz);
    Player player(config_for(OutputFormat::binaural), hrtf, {impulse(4096)});
    SourceSound sound;
    sound.direct = path_of(480, 1, {0, distinctness, 0});
    sound.direct->length_m = distance_m;
    player.publish({sound});
    player.play_until(4096);
    return {level_db(player.output(0), frequency_hz), level_db(player.output(1), frequency_hz)};
}

}  // namespace

TEST_CASE("The shelves of a near source are within 1.5 dB of the rigid sphere") {
    double worst_db = 0;
    double without_db = 0;
    for (const double distance_m : {0.12, 0.13, 0.15, 0.185, 0.25, 0.4, 0.7, 1.0}) {
        for (int angle_deg = 0; angle_deg <= 180; angle_deg += 12) {
            const double cosine = std::cos(angle_deg * std::numbers::pi / 180);
            const auto shelf =
                HeadShelf::at(static_cast<float>(distance_m), static_cast<float>(kReference_m),
                              static_cast<float>(cosine));
            for (const double frequency_hz :
                 {125.0, 250.0, 500.0, 1000.0, 2000.0, 4000.0, 8000.0}) {
                const double sphere_db = rigid_sphere_db(distance_m, cosine, frequency_hz) -
                                         rigid_sphere_db(kReference_m, cosine, frequency_hz);
                worst_db = std::max(worst_db, std::abs(shelf_db(shelf, frequency_hz) - sphere_db));
                without_db = std::max(without_db, std::abs(sphere_db));
            }
        }
    }
    CAPTURE(worst_db);
    CHECK(worst_db < 1.5);
    // Companion: a level that does not depend on the distance is 13 dB off.
    CHECK(without_db > 10);
}

TEST_CASE("The difference between the ears grows towards the head as on the rigid sphere") {
    for (const double frequency_hz : {250.0, 500.0, 1000.0, 2000.0}) {
        const auto far = ears_db(3, frequency_hz);
        // From the distance of the measurement on, to the bit.
        CHECK(far == ears_db(1.41F, frequency_hz));
        for (const double distance_m : {0.12, 0.25, 0.5}) {
            const auto near = ears_db(static_cast<float>(distance_m), frequency_hz);
            for (const std::size_t ear : {0U, 1U}) {
                const double cosine = ear == 0 ? 1 : -1;
                const double sphere_db = rigid_sphere_db(distance_m, cosine, frequency_hz) -
                                         rigid_sphere_db(kReference_m, cosine, frequency_hz);
                CAPTURE(frequency_hz, distance_m, ear);
                CHECK(std::abs(near[ear] - far[ear] - sphere_db) < 1.5);
            }
        }
    }
}

TEST_CASE("At the centre of the head the ears are equal, and levels are continuous") {
    const auto centre = ears_db(0.001F, 1000, 0.01F);
    CHECK(std::abs(centre[0] - centre[1]) < 0.3);
    for (const float distance_m : {0.03F, 0.06F, 0.0999F, 0.12F, 0.5F, 1.3999F}) {
        const auto at = [&](float d) { return ears_db(d, 1000, std::min(1.0F, d / 0.1F)); };
        const auto here = at(distance_m);
        const auto there = at(distance_m * 1.01F);
        for (const std::size_t ear : {0U, 1U}) CHECK(std::abs(here[ear] - there[ear]) < 0.6);
    }
}
