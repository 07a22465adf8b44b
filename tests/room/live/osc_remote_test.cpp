#include "apps/room/remote/osc_remote.h"

#include <unistd.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "tests/support/test_scenes.h"
#include "tests/support/wait.h"

using namespace aula;
using namespace aula::test;

namespace {

/// The address of a host on this machine that no other process uses.
std::string own_host() {
    const int id = getpid();
    return "127." + std::to_string(1 + id / 40'000) + "." + std::to_string(id / 200 % 200) + "." +
           std::to_string(2 + id % 200);
}

}  // namespace

TEST_CASE("Messages of all dialects on one port move a player's room, and queries are answered") {
    PlaybackOptions playback;
    playback.output = OutputFormat::mono;
    playback.device = AudioDevice::kNone;
    playback.duration_s = 1000;
    Scene scene = small_room();
    scene.simulation.rays = 50;
    Player player(scene, playback);
    OscRemote remote({.address = "0", .adm_origin = Vec3(2, 2, 1), .adm_radius_m = 2.0F}, player,
                     scene);
    std::vector<OscMessage> answers;
    OscInput sender(own_host() + ":4002",
                    [&](const OscMessage& answer) { answers.push_back(answer); });
    const auto send = [&](const std::string& address, const std::vector<double>& numbers) {
        OscAnswer message{{.address = address}, std::string(numbers.size(), 'f')};
        for (const double number : numbers) message.message.arguments.emplace_back(number);
        sender.send("127.0.0.1", remote.port(), message);
    };
    send("/adm/obj/1/xyz", {0.5, -0.25, 0});
    CHECK(eventually([&] { return player.source_positions()[0] == Vec3(1.5F, 1, 1); }));
    send("/adm/obj/1/xyz", {});
    CHECK(eventually([&] {
        sender.wait(0);
        return !answers.empty();
    }));
    REQUIRE(answers.size() == 1);
    CHECK(answers[0].address == "/adm/obj/1/xyz");
    CHECK((answers[0].number(0) == 0.5 && answers[0].number(1) == -0.25));
    send("/adm/lis/xyz", {0, 0.5, 0.25});
    CHECK(eventually([&] { return player.status().listener.position == Vec3(3, 2, 1.5F); }));
    send("/SceneRotator/quaternions", {std::sqrt(0.5), 0, 0, std::sqrt(0.5)});
    CHECK(eventually([&] { return std::abs(player.status().listener.yaw_rad - 1.5708F) < 1e-3F; }));
    CHECK(player.status().listener.position == Vec3(3, 2, 1.5F));
    send("/aula/listener/orientation", {0, 0, 0});
    CHECK(eventually([&] { return player.status().listener.yaw_rad == 0; }));
}
