#include "apps/window/view/direct_lines.h"

#include <catch2/catch.hpp>
#include <glm/geometric.hpp>

using namespace aula;

namespace {

using Kind = SoundPath::Kind;

constexpr std::uint64_t kMain = 0;

SoundPath path_of(Kind kind, std::uint64_t key, std::vector<Vec3> apexes, float energy) {
    SoundPath path;
    path.kind = kind;
    path.key = key;
    path.is_main = key == kMain;
    path.edges = static_cast<int>(apexes.size());
    path.apexes = std::move(apexes);
    path.energy = Bands::filled(energy);
    return path;
}

}  // namespace

TEST_CASE("Direct lines lead over the apexes, and their opacity follows the level") {
    EnergyResponse response;
    response.paths = {path_of(Kind::bent, kMain, {{1, 1, 0}, {2, 1, 0}}, 1),
                      path_of(Kind::bent, 7, {{1, 0, 1}}, 0.01F),
                      path_of(Kind::through_walls, 1, {}, 1e-9F),
                      path_of(Kind::bent, 8, {{1, 0, -1}}, 0)};
    SoundPath reflection = path_of(Kind::image, 9, {}, 5);
    reflection.order = 1;
    response.paths.push_back(reflection);
    const auto lines = direct_lines(response, {0, 0, 0}, {3, 0, 0});
    // Neither the reflection nor the path without energy is drawn.
    REQUIRE(lines.size() == 3);
    CHECK(lines[0].points == std::vector<Vec3>{{0, 0, 0}, {1, 1, 0}, {2, 1, 0}, {3, 0, 0}});
    CHECK(lines[0].is_primary);
    CHECK(lines[0].opacity == 1);
    CHECK(lines[1].points.size() == 3);
    CHECK_FALSE(lines[1].through_walls);
    // -20 dB: half of the range, 0.55, and two thirds of it.
    CHECK(lines[1].opacity == Approx(0.55F * 2 / 3).epsilon(1e-5));
    CHECK(lines[2].points == std::vector<Vec3>{{0, 0, 0}, {3, 0, 0}});
    CHECK(lines[2].through_walls);
    CHECK_FALSE(lines[2].is_primary);
    CHECK(lines[2].opacity == Approx(0.1F * 2 / 3));
    CHECK(direct_lines({}, {0, 0, 0}, {3, 0, 0}).empty());
}

TEST_CASE("The direct sound is described by its primary path, or by the one through walls") {
    EnergyResponse response;
    CHECK(direct_sound_text(response) == "not in sight");
    response.paths = {path_of(Kind::through_walls, 1, {}, 1)};
    CHECK(direct_sound_text(response) == "through walls");
    response.paths.push_back(path_of(Kind::bent, kMain, {{1, 0, 0}, {2, 0, 0}}, 1));
    CHECK(direct_sound_text(response) == "around 2 edges");
    response.paths[1] = path_of(Kind::bent, kMain, {{1, 0, 0}}, 1);
    CHECK(direct_sound_text(response) == "around an edge");
    response.paths[1] = path_of(Kind::direct, kMain, {}, 1);
    CHECK(direct_sound_text(response) == "in sight");
    response.paths[1].order = 1;
    CHECK(direct_sound_text(response) == "through walls");
}

TEST_CASE("Dashes begin and end with the line, and gaps are as long as dashes") {
    for (const float length_m : {0.01F, 0.3F, 1.0F, 7.3F}) {
        INFO(length_m << " m");
        const Vec3 from{1, 2, 3};
        const Vec3 to = from + Vec3(0, length_m, 0);
        const auto all = dashes(from, to, 0.1F);
        CHECK(glm::distance(all.front()[0], from) < 1e-6F);
        CHECK(glm::distance(all.back()[1], to) < 1e-6F);
        const float dash_m = glm::distance(all[0][0], all[0][1]);
        if (length_m > 0.3F) CHECK(dash_m == Approx(0.1F).epsilon(0.15));
        for (std::size_t i = 1; i < all.size(); ++i)
            CHECK(glm::distance(all[i - 1][1], all[i][0]) == Approx(dash_m).epsilon(1e-3));
    }
}
