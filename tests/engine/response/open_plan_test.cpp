#include "engine/response/open_plan.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

namespace {

using namespace aula;

/// Levels that fall by `d2s_db` per doubled distance from `at_4_m_dba` on, indices by 0.04 per
/// metre from 0.8 on.
std::vector<SpeechAtReceiver> line(const std::vector<double>& distances_m, double d2s_db = 5,
                                   double at_4_m_dba = 50) {
    std::vector<SpeechAtReceiver> receivers;
    for (const double r : distances_m)
        receivers.push_back({Vec3(static_cast<float>(r), 0, 0),
                             at_4_m_dba - d2s_db * std::log2(r / 4), 0.8 - 0.04 * r});
    return receivers;
}

}  // namespace

TEST_CASE("speech of ISO 3382-3 has 57.4 dB(A)") {
    // Its octaves at 1 m from 125 Hz on.
    CHECK(a_weighted_db(kOpenPlanSpeech_db) == Approx(57.4).margin(0.05));
    // 1 kHz has the weight 0, 63 Hz -26.2 dB.
    CHECK(a_weighted_db({{-100, -100, -100, -100, 70, -100, -100, -100}}) == Approx(70));
    CHECK(a_weighted_db({{70, -100, -100, -100, -100, -100, -100, -100}}) == Approx(43.8));
}

TEST_CASE("a line of receivers has the slope, the level at 4 m and the distances of its lines") {
    const OpenPlanParameters p = open_plan_parameters(line({2, 4, 7, 11, 16})).value();
    CHECK(p.d2s_db == Approx(5));
    CHECK(p.lp_as_4m_dba == Approx(50));
    CHECK(p.rd_m.value() == Approx(7.5));
    CHECK(p.rp_m.value() == Approx(15));
}

TEST_CASE("receivers nearer than 2 m and farther than 16 m do not count") {
    auto receivers = line({2, 4, 7, 11});
    receivers.push_back({{1, 0, 0}, 90, 0.9});
    receivers.push_back({{30, 0, 0}, 90, 0.9});
    CHECK(open_plan_parameters(receivers)->line == std::vector<std::size_t>{0, 1, 2, 3});
    CHECK(open_plan_parameters(receivers)->d2s_db == Approx(5));
    CHECK_FALSE(open_plan_parameters(line({1, 2, 4, 7, 17})));
    CHECK_FALSE(open_plan_parameters({}));
}

TEST_CASE("receivers within a doubling of the distance have no slope") {
    CHECK_FALSE(open_plan_parameters(line({4, 4, 4, 4})));
    CHECK_FALSE(open_plan_parameters(line({4, 5, 6, 7.9})));
    CHECK(open_plan_parameters(line({4, 5, 6, 8})));
}

TEST_CASE("receivers on raked seats are no line") {
    auto receivers = line({2, 4, 7, 11});
    for (SpeechAtReceiver& receiver : receivers)
        receiver.from_talker_m.z = 0.2F * receiver.from_talker_m.x;
    CHECK_FALSE(open_plan_parameters(receivers));
    for (SpeechAtReceiver& receiver : receivers) receiver.from_talker_m.z = -0.4F;
    CHECK(open_plan_parameters(receivers));
}

TEST_CASE("only receivers in one direction are a line") {
    // Around the talker, as in a lecture hall.
    auto receivers = line({2, 4, 7, 11});
    receivers[0].from_talker_m = {0, 2, 0};
    CHECK_FALSE(open_plan_parameters(receivers));
    // A second line with more receivers; 14 degrees are still in its direction.
    const auto other = line({2, 4, 8, 12, 16}, 7);
    receivers = line({3, 6, 12, 15});
    for (SpeechAtReceiver receiver : other) {
        receiver.from_talker_m = receiver.from_talker_m.x * Vec3(-std::cos(0.1), std::sin(0.1), 0);
        receivers.push_back(receiver);
    }
    const float r = receivers[6].from_talker_m.x / -std::cos(0.1F);
    receivers[6].from_talker_m = r * Vec3(-std::cos(0.34), std::sin(0.34), 0);
    CHECK(open_plan_parameters(receivers)->line == std::vector<std::size_t>{4, 5, 6, 7, 8});
    CHECK(open_plan_parameters(receivers)->d2s_db == Approx(7));
    receivers[6].from_talker_m = r * Vec3(-std::cos(0.38), std::sin(0.38), 0);
    CHECK(open_plan_parameters(receivers)->line.size() == 4);
}

TEST_CASE("distances are empty where an index is unknown or does not fall") {
    auto receivers = line({2, 4, 7, 11});
    receivers[1].sti.reset();
    CHECK_FALSE(open_plan_parameters(receivers)->rd_m);
    for (SpeechAtReceiver& receiver : receivers) receiver.sti = 0.7;
    CHECK(open_plan_parameters(receivers)->d2s_db == Approx(5));
    CHECK_FALSE(open_plan_parameters(receivers)->rd_m);
    // An index below 0.5 everywhere: its line has 0.5 before the talker.
    for (SpeechAtReceiver& receiver : receivers) receiver.sti = 0.4 - 0.01 * receiver.distance_m();
    CHECK_FALSE(open_plan_parameters(receivers)->rd_m);
    CHECK(open_plan_parameters(receivers)->rp_m.value() == Approx(20));
}
