// Sound through walls: levels behind them, against exact values.

#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "aula/engine/propagation.h"
#include "aula/engine/scene_file.h"
#include "engine/base/sampling.h"
#include "tests/engine/rooms_in_row.h"
#include "tests/support/measure.h"

using namespace aula;
using aula::test::add_partition;
using aula::test::partition_at;
using aula::test::quad;
using aula::test::row_of_rooms;
using nlohmann::json;

namespace {

double decibels(double ratio) { return 10 * std::log10(ratio); }

struct Reference {
    Scene scene;
    json expect;

    double number(const char* key) const { return expect.at(key).get<double>(); }
    double number(const char* key, std::size_t band) const {
        return expect.at(key).at(band).get<double>();
    }
};

Reference reference(const std::string& name) {
    const auto file =
        std::filesystem::path(AULA_SOURCE_DIR) / "scenes/reference" / (name + ".json");
    std::ifstream stream(file);
    const json content = json::parse(stream, nullptr, true, true);
    return {load_scene(file).scene, content.at("expect")};
}

/// Positions in a regular arrangement in a room that begins at x.
std::vector<Vec3> positions(float x_m) {
    std::vector<Vec3> all;
    for (const float x : {0.125F, 0.375F, 0.625F, 0.875F}) {
        for (const float y : {0.125F, 0.375F, 0.625F, 0.875F}) {
            for (const float z : {1.0F / 6, 0.5F, 5.0F / 6}) {
                all.emplace_back(x_m + 5 * x, 4 * y, 3 * z);
            }
        }
    }
    return all;
}

std::vector<std::vector<double>> room_means(const Scene& scene, Simulation simulation,
                                            const std::vector<float>& rooms_x_m, int frames) {
    simulation.direct = false;
    simulation.memory_mb = 20000;  // a limit: the size of the patches does not depend on it
    FrameInput input;
    input.sources = {scene.sources[0].position};
    for (const float x_m : rooms_x_m) {
        for (const Vec3& p : positions(x_m)) input.listeners.push_back(p);
    }
    Propagation propagation(scene, simulation, input.listeners.size());
    const std::size_t per_room = input.listeners.size() / rooms_x_m.size();
    std::vector<std::vector<double>> means(rooms_x_m.size(), std::vector<double>(kBandCount, 0));
    for (int f = 0; f < frames; ++f) {
        propagation.step(input);
        for (std::size_t l = 0; l < input.listeners.size(); ++l) {
            for (std::size_t b = 0; b < kBandCount; ++b) {
                means[l / per_room][b] += test::total(propagation.response(0, l), b) /
                                          static_cast<double>(per_room) / frames;
            }
        }
    }
    return means;
}

/// The volume mean of 1 / (4 pi d^2) in a room of 5 x 4 x 3 m is the mean distance of its walls
/// from the source over the volume.
double mean_direct(const Vec3& source) {
    constexpr std::uint32_t kDirections = 1 << 16;
    const ScrambledSobol sobol(1);
    double sum_m = 0;
    for (std::uint32_t i = 0; i < kDirections; ++i) {
        const Vec3 u = uniform_direction(sobol.point(i));
        float wall_m = std::numeric_limits<float>::infinity();
        for (int axis = 0; axis < 3; ++axis) {
            const float size_m = axis == 0 ? 5 : axis == 1 ? 4 : 3;
            wall_m = std::min(
                wall_m, (u[axis] > 0 ? size_m - source[axis] : source[axis]) / std::abs(u[axis]));
        }
        sum_m += double{wall_m};
    }
    return sum_m / kDirections / 60;
}

}  // namespace

TEST_CASE(
    "the level difference of two rooms is that of the exact transport, not of a diffuse field") {
    const Reference r = reference("partition_D");
    Simulation simulation = r.scene.simulation;
    simulation.rays = 6000;
    const auto means = room_means(r.scene, simulation, {0, 5}, 6);
    const double direct = mean_direct(r.scene.sources[0].position);
    std::vector<double> difference_db;
    for (std::size_t b = 0; b < kBandCount; ++b) {
        const double first = means[0][b] + direct;
        difference_db.push_back(decibels(first / means[1][b]));
        CAPTURE(b, first, difference_db[b]);
        // 0.1 dB: the mean of 48 positions in place of the volume's, and 36,000 rays.
        const double tolerance_db = r.number("tolerance_db");
        CHECK(std::abs(difference_db[b] - r.number("level_difference_db", b)) < tolerance_db);
        CHECK(std::abs(decibels(first / r.number("energy_first_room_per_m2", b))) < tolerance_db);
        // Companion: diffuse-field theory, D = R + 10 lg (A / S).
        CHECK(std::abs(difference_db[b] - r.number("diffuse_field_db", b)) > 3 * tolerance_db);
    }
    // D - R does not depend on R: the bands of the same absorption, 20 to 60 dB.
    const Bands reduction_db = *r.scene.find_material("partition").sound_reduction_db;
    const auto rest_db = [&](std::size_t b) { return difference_db[b] - double{reduction_db[b]}; };
    for (const std::size_t b : {2U, 5U, 6U, 7U}) {
        CAPTURE(b, rest_db(1), rest_db(b));
        // At 60 dB, 40 dB more than the paths are chosen by, the noise is 0.03 dB.
        CHECK(std::abs(rest_db(b) - rest_db(1)) < (b == 7 ? 0.12 : 0.03));
    }
}

TEST_CASE("two lossless rooms level out at the rate of the partition, and lose nothing") {
    const Reference r = reference("partition_lossless");
    Simulation simulation = r.scene.simulation;
    simulation.direct = false;
    simulation.rays = 2000;
    FrameInput input;
    input.sources = {r.scene.sources[0].position};
    input.listeners = {Vec3(2.5F, 2.6F, 1.3F), Vec3(7.3F, 2.9F, 1.2F)};
    Propagation propagation(r.scene, simulation, 2);
    constexpr int kFrames = 6;
    // Fluence per second in both rooms, in intervals of 0.25 s.
    std::vector<std::array<double, 2>> rate(15);
    for (int f = 0; f < kFrames; ++f) {
        propagation.step(input);
        for (std::size_t k = 0; k < rate.size(); ++k) {
            for (const std::size_t room : {0U, 1U}) {
                const double begin_s = 0.25 * static_cast<double>(k);
                rate[k][room] += test::energy_between(propagation.response(0, room), begin_s,
                                                      begin_s + 0.25, 4) /
                                 0.25 / kFrames;
            }
        }
    }
    const double a = r.number("fluence_rate_per_m2_s");
    const double tolerance = r.number("relative_tolerance");
    for (std::size_t k = 1; k < rate.size(); ++k) {
        const double decay =
            std::exp(-r.number("rate_1_s") * 0.25 * (static_cast<double>(k) + 0.5));
        CAPTURE(k, rate[k][0], rate[k][1]);
        CHECK(rate[k][0] == Approx(a * (1 + decay)).epsilon(tolerance));
        CHECK(rate[k][1] == Approx(a * (1 - decay)).margin(2 * a * tolerance));
        CHECK(rate[k][0] + rate[k][1] == Approx(2 * a).epsilon(tolerance));
    }
    // Companion: a tenth more sound reduction, 0.4 dB, at the end.
    const double slower = std::exp(-0.9 * r.number("rate_1_s") * 3.625);
    CHECK(rate.back()[1] != Approx(a * (1 - slower)).margin(2 * a * tolerance));
}

TEST_CASE("an infinite wall of one face or two radiates what it transmits diffusely") {
    Reference r = reference("two_faced_wall");
    Simulation simulation = r.scene.simulation;
    simulation.rays = 20000;
    const double h_m = r.number("height_m");
    const double d_m = r.number("direct_distance_m");
    const Material wall = r.scene.find_material("wall");
    const Bands tau = wall.transmission();
    for (const bool two_faces : {true, false}) {
        Scene scene = r.scene;
        if (!two_faces) scene.objects.pop_back();
        const float distance_m = two_faces ? static_cast<float>(d_m) : static_cast<float>(2 * h_m);
        scene.listener.pose.position.x = distance_m - static_cast<float>(h_m);
        Propagation propagation(scene, simulation);
        const EnergyResponse e = test::mean_response(propagation, scene, 8);
        REQUIRE(propagation.response(0).paths.size() == 1);
        const SoundPath& path = propagation.response(0).paths[0];
        CHECK(path.kind == SoundPath::Kind::through_walls);
        CHECK(path.length_m == Approx(distance_m).epsilon(1e-6));
        for (std::size_t b = 0; b < kBandCount; ++b) {
            const double s = double{wall.scattering[b]};
            const double direct =
                (1 - s) * double{tau[b]} / (4 * std::numbers::pi) / std::pow(double{distance_m}, 2);
            const double diffuse = s * double{tau[b]} / (8 * std::numbers::pi * h_m * h_m);
            CAPTURE(two_faces, b, test::total(e, b), diffuse, path.energy[b], direct);
            CHECK(double{path.energy[b]} ==
                  Approx(direct).epsilon(r.number("direct_relative_tolerance")));
            CHECK(test::total(e, b) ==
                  Approx(diffuse).epsilon(r.number("diffuse_relative_tolerance")));
            // Companion: if both faces counted.
            if (b > 0) CHECK(test::total(e, b) > 2 * diffuse * double{tau[b]});
        }
        // In time: E [1 - (h / r)^4] until c t = 2 r, of the diffuse part in the last band, later
        // by the passage of the wall. The first bins smear by the size of a patch.
        const double c = double{e.speed_of_sound_m_s};
        for (const double t : {0.04, 0.06, 0.1}) {
            const double r_m = (c * t - (double{distance_m} - 2 * h_m)) / 2;
            const double until =
                double{tau[7]} / (8 * std::numbers::pi * h_m * h_m) * (1 - std::pow(h_m / r_m, 4));
            CAPTURE(two_faces, t);
            CHECK(test::energy_between(e, 0, t, 7) == Approx(until).epsilon(0.015));
        }
    }
}

TEST_CASE("the passage of a wall of two faces takes the time of its thickness") {
    // Two faces 0.5 m apart across a free field.
    constexpr float kThickness_m = 0.5F;
    Scene scene = test::grey_room({}, 0.5F, 1, Vec3(-1, 0, 0), Vec3(1 + kThickness_m, 0, 0));
    scene.materials[0].sound_reduction_db = Bands::filled(10);
    scene.objects.clear();
    for (const float x : {0.0F, kThickness_m})
        scene.objects.push_back(quad({{x, -9, -9}, {x, 9, -9}, {x, 9, 9}, {x, -9, 9}}, 0));
    Propagation propagation(scene, scene.simulation);
    const EnergyResponse e = test::mean_response(propagation, scene, 8);
    const double straight_s = double{2 + kThickness_m} / static_cast<double>(e.speed_of_sound_m_s);
    // Energies are divided between neighbouring bins of 1 ms. The wall takes 1.5 ms.
    CHECK(test::energy_between(e, 0, straight_s - 0.001, 4) == 0);
    CHECK(test::energy_between(e, straight_s - 0.001, straight_s + 0.003, 4) > 0);
}

TEST_CASE("sound that a gather ray meets behind a wall has passed its thickness") {
    // Behind the source, seen through two smooth faces 0.5 m apart, a plate scatters.
    constexpr float kThickness_m = 0.5F;
    Scene scene = test::grey_room({}, 0.5F, 1, Vec3(-1, 0, 0), Vec3(1 + kThickness_m, 0, 0));
    Material smooth = scene.materials[0];
    smooth.scattering = Bands{};
    smooth.sound_reduction_db = Bands::filled(5);
    scene.materials.push_back(smooth);
    scene.objects.clear();
    for (const float x : {0.0F, kThickness_m})
        scene.objects.push_back(quad({{x, -9, -9}, {x, 9, -9}, {x, 9, 9}, {x, -9, 9}}, 1));
    scene.objects.push_back(quad({{-5, -1, -1}, {-5, 1, -1}, {-5, 1, 1}, {-5, -1, 1}}, 0));
    Propagation propagation(scene, scene.simulation);
    const EnergyResponse e = test::mean_response(propagation, scene, 8);
    const double shortest_s = (4 + 6 + double{kThickness_m}) / double{e.speed_of_sound_m_s};
    // Energies are divided between neighbouring bins of 1 ms, patches of 0.5 m are as long; the
    // passage takes 1.5 ms.
    const double before = test::energy_between(e, 0, shortest_s - 0.0015, 4);
    CHECK(before < 0.02 * test::energy_between(e, 0, shortest_s + 0.02, 4));
}

TEST_CASE("a door in a partition adds what it transmits") {
    // Little absorption, so that the field is even.
    const Reference r = reference("partition_door");
    const auto level_difference_db = [&](std::optional<double> reduction_db) {
        Scene scene = r.scene;
        for (Material& material : scene.materials) {
            if (material.sound_reduction_db && reduction_db)
                material.sound_reduction_db = Bands::filled(static_cast<float>(*reduction_db));
        }
        Simulation simulation = scene.simulation;
        simulation.rays = 6000;
        const auto means = room_means(scene, simulation, {0, 5}, 2);
        return decibels(means[0][0] / means[1][0]);
    };
    const double parts_db = level_difference_db(std::nullopt);
    const double whole_db = level_difference_db(r.number("sound_reduction_db"));
    CAPTURE(parts_db, whole_db);
    // The door is not where the mean of the field is.
    CHECK(std::abs(parts_db - whole_db) < r.number("tolerance_db"));
    // Companion: the mean of the decibels.
    const double mean_db = level_difference_db(r.number("mean_of_decibels_db"));
    CHECK(std::abs(parts_db - mean_db) > 10);
}

TEST_CASE("reference: two walls reduce the direct sound by both sound reductions") {
    const Reference r = reference("two_walls");
    Propagation propagation(r.scene, r.scene.simulation);
    const auto at = [](const json& list) {
        return Vec3(list.at(0).get<float>(), list.at(1).get<float>(), list.at(2).get<float>());
    };
    const std::size_t cases = r.expect.at("cases").size();
    for (std::size_t i = 0; i < cases; ++i) {
        const json& c = r.expect.at("cases").at(i);
        const json& another = r.expect.at("cases").at((i + 1) % cases);
        const Vec3 source = at(c.at("source"));
        const Vec3 listener = at(c.at("listener"));
        propagation.step({.sources = {source}, .listeners = {listener}});
        REQUIRE(propagation.response(0).paths.size() == 1);
        const SoundPath& path = propagation.response(0).paths[0];
        CHECK(path.kind == SoundPath::Kind::through_walls);
        const Vec3 offset = listener - source;
        const double free = 1 / (4 * std::numbers::pi * double{glm::dot(offset, offset)});
        for (std::size_t b = 0; b < kBandCount; ++b) {
            const double level_db = decibels(double{path.energy[b]} / free);
            const auto error_db = [&](const json& of) {
                return std::abs(level_db - of.at("level_db").at(b).get<double>());
            };
            CAPTURE(c.at("name").get<std::string>(), b, level_db);
            CHECK(error_db(c) < r.number("tolerance_db"));
            CHECK(error_db(another) > 1);  // companion: other walls
        }
    }
}

TEST_CASE("behind two partitions the level falls by both sound reductions") {
    // Each band is one case: R of both partitions together is 20 to 55 dB.
    Scene scene = row_of_rooms(3, 0.2F, 1);
    add_partition(scene, 5, 10.0F);
    add_partition(scene, 10, 10.0F);
    const Bands first{{10, 12, 15, 18, 20, 22, 25, 25}};
    const Bands second{{10, 14, 15, 20, 20, 24, 25, 30}};
    scene.materials[1].sound_reduction_db = first;
    scene.materials[2].sound_reduction_db = second;
    Simulation simulation = test::with(scene, Estimator::patch, 1.5F);
    simulation.rays = 6000;
    const auto means = room_means(scene, simulation, {0, 10}, 6);
    std::vector<double> rest_db;
    for (std::size_t b = 0; b < kBandCount; ++b) {
        rest_db.push_back(decibels(means[0][b] / means[1][b]) - double{first[b] + second[b]});
    }
    for (std::size_t b = 2; b < kBandCount; ++b) {
        CAPTURE(b, rest_db[2], rest_db[b]);
        CHECK(std::abs(rest_db[b] - rest_db[2]) < 0.2);
    }
    // A little more returns through walls of 10 dB.
    CHECK(std::abs(rest_db[0] - rest_db[2]) < 0.4);
    // Companions: one of the walls alone, or the one of the higher sound reduction.
    const auto without = [&](std::size_t b, float reduction_db) {
        return rest_db[b] + double{reduction_db};
    };
    const std::size_t last = kBandCount - 1;
    CHECK(std::abs(without(last, first[last]) - without(2, first[2])) > 1);
    CHECK(std::abs(without(last, second[last]) - without(2, second[2])) > 1);
    CHECK(std::abs(without(last, std::min(first[last], second[last])) -
                   without(2, std::min(first[2], second[2]))) > 1);
}
