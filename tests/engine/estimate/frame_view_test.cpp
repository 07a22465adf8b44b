#include "engine/estimate/frame_view.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <numbers>
#include <set>
#include <utility>

#include "aula/engine/propagation.h"
#include "tests/support/test_scenes.h"

using namespace aula;

namespace {

FrameInput input_of(const Scene& scene) {
    return {0, {scene.sources[0].position}, {scene.listener.pose.position}};
}

}  // namespace

TEST_CASE("Path lines start at the source, end on walls and lose the energy that walls absorb") {
    const Scene scene = test::small_room();
    Propagation propagation(scene, scene.simulation);
    const FrameInput input = input_of(scene);
    CHECK(propagation.path_lines(input, 0, 10, 4).empty());  // before the first frame
    propagation.step(input);
    const auto lines = propagation.path_lines(input, 0, 50, 4);
    REQUIRE(lines.size() == 50);
    for (const PathLine& line : lines) {
        REQUIRE(line.points.size() == 5);
        REQUIRE(line.points.size() == line.energy.size());
        CHECK(line.points[0] == scene.sources[0].position);
        for (std::size_t i = 1; i < line.points.size(); ++i) {
            const Vec3 p = line.points[i];
            const float to_wall_m = std::min({p.x, 5 - p.x, p.y, 4 - p.y, p.z, 3 - p.z});
            CHECK(std::abs(to_wall_m) < 2e-4F);  // tolerances::kOffset_m and rounding
        }
        // Absorption and scattering are equal in all bands: a reflection leaves 0.7 exactly.
        CHECK(static_cast<double>(line.energy[4]) == Approx(std::pow(0.7, 4)).epsilon(1e-4));
    }
    CHECK(propagation.path_lines(input, 0, 5000, 2).size() ==
          static_cast<std::size_t>(scene.simulation.ray_count()));
}

TEST_CASE("Path lines are the paths of the last frame") {
    // Diffuse reflections only, by path tracing: a response of first-order paths.
    Scene scene = test::small_room();
    scene.materials[0].scattering = Bands::filled(1);
    Simulation& simulation = scene.simulation;
    simulation.estimator = Estimator::pt;
    simulation.direct = false;
    simulation.specular = false;
    simulation.specular_order = 0;
    simulation.rays = 5000;
    simulation.order = 1;
    const FrameInput input = input_of(scene);
    Propagation heard(scene, simulation);
    simulation.order = 2;
    Propagation seen(scene, simulation);
    const double speed_m_s{seen.response(0).speed_of_sound_m_s};
    for (int frame = 0; frame < 3; ++frame) {
        heard.step(input);
        seen.step(input);
        const EnergyResponse& response = heard.response(0);
        const TimeBins& bins = response.bins;
        // The bins of the paths whose second segment passes the listener's sphere.
        std::set<std::size_t> expected;
        for (const PathLine& line : seen.path_lines(input, 0, simulation.ray_count(), 2)) {
            REQUIRE(line.points.size() == 3);
            const Vec3 from = line.points[1];
            const Vec3 direction = glm::normalize(line.points[2] - from);
            const float nearest_m = glm::dot(input.listeners[0] - from, direction);
            if (nearest_m < 0 || glm::distance(from + nearest_m * direction, input.listeners[0]) >
                                     simulation.listener_radius_m) {
                continue;
            }
            const float before_m = glm::distance(line.points[0], from);
            expected.insert(bins.index(double{before_m + nearest_m} / speed_m_s));
        }
        std::set<std::size_t> found;
        for (std::size_t k = 0; k < bins.count(); ++k)
            if (response.energy[k].max() > 0) found.insert(k);
        CHECK(expected.size() > 5);
        CHECK(found == expected);
    }
}

TEST_CASE(
    "The energies of all patches sum to the energy that walls scatter, and those of time intervals "
    "to the total") {
    Scene scene = test::small_room();
    scene.simulation.order = 1;
    Propagation propagation(scene, scene.simulation);
    propagation.step(input_of(scene));
    const double cell_m2 = std::pow(static_cast<double>(propagation.patch_size_m()), 2);
    const auto total = [&](double begin_s, double end_s) {
        double sum = 0;
        for (const PatchEnergy& patch : propagation.patch_energies(0, begin_s, end_s)) {
            CHECK(glm::length(patch.cell.direction) == 1.0F);
            CHECK(patch.energy.max() > 0);
            sum += static_cast<double>(patch.energy[4]) * cell_m2;
        }
        return sum;
    };
    // Each ray leaves 0.7 of its energy at its first wall, half of it scattered. 5 x 4 x 3 m are
    // whole patches of 0.5 m.
    CHECK(total(0, 1) == Approx(0.35).epsilon(0.02));  // areas are sampled, 16 points a patch
    const double all = total(0, 1);
    CHECK(total(0, 0.0045) + total(0.0055, 1) == Approx(all).epsilon(1e-4));
    CHECK(total(0, 0.0045) > 0.05 * all);

    scene.simulation.estimator = Estimator::dpc;
    Propagation other(scene, scene.simulation);
    other.step(input_of(scene));
    CHECK(other.patch_energies(0, 0, 1).empty());
    CHECK(other.patch_size_m() == 0);
}

TEST_CASE("The energies of the sides of a moving panel add up to those of the patches without it") {
    // A leaf perpendicular to the wall x = 0, in one plane with the source: it casts no shadow. It
    // divides patches of the wall by 1 : 4.
    const auto energies_by_cell = [](bool has_leaf) {
        Scene scene = test::small_room();
        scene.simulation.order = 1;
        scene.simulation.rays = 20000;
        scene.sources[0].position.y = 2.1F;
        if (has_leaf) {
            Object leaf;
            leaf.vertices = {{0.01F, 0, 0.5F}, {0.8F, 0, 0.5F}, {0.8F, 0, 2.5F}, {0.01F, 0, 2.5F}};
            leaf.triangles = {{0, 1, 2}, {0, 2, 3}};
            leaf.triangle_materials = {0, 0};
            leaf.translation = {0, 2.1F, 0};
            leaf.movable = true;
            scene.objects.push_back(leaf);
        }
        Propagation propagation(scene, scene.simulation);
        propagation.step(input_of(scene));
        std::map<std::array<float, 3>, double> by_cell;  // of the wall x = 0
        int rows = 0;
        for (const PatchEnergy& patch : propagation.patch_energies(0, 0, 1)) {
            if (std::abs(patch.cell.direction.x) < 0.5F || patch.cell.low.x > 0.1F) continue;
            ++rows;
            by_cell[{patch.cell.low.x, patch.cell.low.y, patch.cell.low.z}] +=
                double{patch.energy[4]};
        }
        return std::pair(by_cell, rows);
    };
    const auto [without, cells] = energies_by_cell(false);
    const auto [with, rows] = energies_by_cell(true);
    CHECK(rows > cells);
    REQUIRE(with.size() == without.size());
    for (const auto& [low, energy] : without) {
        CAPTURE(low[1], low[2]);
        // Areas of sides are known by 256 samples of a patch, and a fifth of them is on one side.
        REQUIRE(with.count(low) == 1);
        CHECK(with.at(low) == Approx(energy).epsilon(0.1));
    }
}

TEST_CASE("Edge lines are the edges of the scene, and paths around them bend at points on them") {
    // A panel of 2 x 2 m in free space: four free edges.
    Scene scene = test::free_field({-1, 0.3F, 0});
    scene.listener.pose.position = {1.5F, 0, 0.2F};
    scene.materials.push_back({"panel", Bands::filled(0.1F), Bands::filled(0.1F)});
    Object panel;
    panel.vertices = {{0, -1, -1}, {0, 1, -1}, {0, 1, 1}, {0, -1, 1}};
    panel.triangles = {{0, 1, 2}, {0, 2, 3}};
    panel.triangle_materials = {0, 0};
    scene.objects.push_back(panel);
    Propagation propagation(scene, scene.simulation);
    propagation.step(input_of(scene));
    const std::vector<EdgeLine> edges = propagation.edge_lines();
    REQUIRE(edges.size() == 4);
    for (const EdgeLine& edge : edges) {
        CHECK(glm::distance(edge.from, edge.to) == Approx(2).margin(1e-3));
        CHECK(edge.bend_rad == Approx(std::numbers::pi).margin(1e-3));
        CHECK(edge.triangle < 2);
        CHECK(std::abs(edge.facing.x) == Approx(1).margin(1e-5));
    }
    const auto on_edge = [&](const Vec3& point) {
        return std::any_of(edges.begin(), edges.end(), [&](const EdgeLine& edge) {
            return std::abs(glm::distance(edge.from, point) + glm::distance(point, edge.to) - 2) <
                   1e-3F;
        });
    };
    const FrameInput input = input_of(scene);
    int bent = 0;
    for (const SoundPath& path : propagation.response(0).paths) {
        CHECK(static_cast<int>(path.apexes.size()) == path.edges);
        if (path.edges != 1) continue;
        ++bent;
        const Vec3& apex = path.apexes[0];
        CHECK(on_edge(apex));
        CHECK(glm::distance(input.sources[0], apex) + glm::distance(apex, input.listeners[0]) ==
              Approx(path.length_m).epsilon(1e-5));
        CHECK(glm::dot(path.direction, glm::normalize(apex - input.listeners[0])) ==
              Approx(1).margin(1e-5));
    }
    CHECK(bent == 4);
    // Companion: the middle of the panel is on no edge.
    CHECK_FALSE(on_edge({0, 0, 0}));

    scene.simulation.diffraction_order = 0;
    Propagation straight(scene, scene.simulation);
    straight.step(input_of(scene));
    CHECK(straight.edge_lines().empty());
}

TEST_CASE("The number of rays can be changed from frame to frame without bias") {
    const Scene scene = test::small_room();
    Propagation propagation(scene, scene.simulation);
    Propagation steady(scene, scene.simulation);
    for (int frame = 0; frame < 40; ++frame) {
        propagation.set_rays(frame % 2 == 0 ? 300 : 2500);
        propagation.step(input_of(scene));
        steady.step(input_of(scene));
    }
    // Some 50000 rays each with a standard deviation below 3: 5 standard errors of both are 0.1.
    const double changing = propagation.response(0).total(4);
    const double constant = steady.response(0).total(4);
    CHECK(changing == Approx(constant).epsilon(0.1));
    // Companion: a third more absorption is detected.
    Scene drier = scene;
    drier.materials[0].absorption = Bands::filled(0.4F);
    Propagation dry(drier, drier.simulation);
    for (int frame = 0; frame < 40; ++frame) dry.step(input_of(drier));
    CHECK(dry.response(0).total(4) != Approx(constant).epsilon(0.1));
}
