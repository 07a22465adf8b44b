#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "aula/engine/propagation.h"
#include "aula/engine/room_acoustics.h"
#include "aula/engine/scene_file.h"
#include "tests/support/statistics.h"

// The reference scenes against the solutions in their files, with the estimator `patch`. Rays and
// frames are so many that the statistical error is at most a third of the file's tolerance.

using aula::Bands;
using aula::EnergyResponse;
using aula::kBandCount;
using aula::Scene;
using nlohmann::json;
namespace fs = std::filesystem;

namespace {

struct Reference {
    Scene scene;
    json expect;

    double number(const char* key) const { return expect.at(key).get<double>(); }
    std::vector<double> list(const char* key) const {
        return expect.at(key).get<std::vector<double>>();
    }
    double tolerance(const char* key) const { return expect.at("tolerance").at(key).get<double>(); }
};

Reference reference(const std::string& name) {
    const fs::path file = fs::path(AULA_SOURCE_DIR) / "scenes/reference" / (name + ".json");
    std::ifstream stream(file);
    const json content = json::parse(stream, nullptr, true, true);
    return {aula::load_scene(file).scene, content.at("expect")};
}

/// The mean response of several frames of `rays` rays.
EnergyResponse response(const Scene& scene, int frames, int rays, int order = 0) {
    aula::Simulation simulation = scene.simulation;
    simulation.rays = rays;
    simulation.seed = aula::test::test_seed();
    if (order > 0) simulation.order = order;
    aula::Propagation propagation(scene, simulation);
    const aula::FrameInput input{.sources = {scene.sources[0].position},
                                 .listeners = {scene.listener.pose.position}};
    // The cache accumulates over all frames; gather rays are new in each frame.
    EnergyResponse mean;
    for (int f = 0; f < frames; ++f) {
        propagation.step(input);
        const EnergyResponse& now = propagation.response(0);
        if (f == 0) {
            mean = now;
            continue;
        }
        for (std::size_t k = 0; k < mean.energy.size(); ++k) mean.energy[k] += now.energy[k];
    }
    for (Bands& energy : mean.energy) energy *= 1.0F / static_cast<float>(frames);
    return mean;
}

/// Energy, mean length and its variance of one reflection order in one band.
struct Order {
    double energy = 0;
    double mean_length_m = 0;
    double length_variance_m2 = 0;
};

/// Orders 1 to `highest`, each as the difference of two limits of the order.
std::vector<Order> orders(const Scene& scene, int highest, int frames, int rays, std::size_t band) {
    std::vector<Order> result;
    std::vector<double> before;
    for (int n = 1; n <= highest; ++n) {
        const EnergyResponse r = response(scene, frames, rays, n);
        before.resize(r.energy.size());
        Order order;
        double first = 0;
        double second = 0;
        for (std::size_t k = 0; k < r.energy.size(); ++k) {
            const double energy = double{r.energy[k][band]} - before[k];
            const double length_m =
                (r.bins.begin_s(k) + r.bins.end_s(k)) / 2 * double{r.speed_of_sound_m_s};
            order.energy += energy;
            first += energy * length_m;
            second += energy * length_m * length_m;
            before[k] = double{r.energy[k][band]};
        }
        order.mean_length_m = first / order.energy;
        order.length_variance_m2 =
            second / order.energy - order.mean_length_m * order.mean_length_m;
        result.push_back(order);
    }
    return result;
}

/// A scene whose source and listener are put at places one after another. Levels are those of the
/// direct sound with its diffraction re free field at the straight distance.
class DirectLevels {
 public:
    explicit DirectLevels(const Scene& scene) : propagation_(scene, scene.simulation) {}

    std::vector<double> operator()(const aula::Vec3& source, const aula::Vec3& listener) {
        propagation_.step({.sources = {source}, .listeners = {listener}});
        Bands sum;
        for (const aula::SoundPath& path : propagation_.response(0).paths) {
            if (path.order == 0) sum += path.energy;
        }
        const double distance_m = double{glm::distance(source, listener)};
        std::vector<double> levels_db;
        for (const float energy : sum.value) {
            levels_db.push_back(10 * std::log10(std::max(1e-30, double{energy}) * 4 *
                                                std::acos(-1) * distance_m * distance_m));
        }
        return levels_db;
    }

    /// Those of the last call.
    const std::vector<aula::SoundPath>& paths() const { return propagation_.response(0).paths; }

 private:
    aula::Propagation propagation_;
};

aula::Vec3 point(const json& list) {
    return {list.at(0).get<float>(), list.at(1).get<float>(), list.at(2).get<float>()};
}

double largest_difference(const std::vector<double>& a, const std::vector<double>& b) {
    double largest = 0;
    for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, std::abs(a[i] - b[i]));
    return largest;
}

}  // namespace

TEST_CASE("reference: free field, direct sound alone") {
    for (const char* name : {"free_field", "free_field_air"}) {
        INFO(name);
        const Reference r = reference(name);
        const EnergyResponse e = response(r.scene, 1, 1);
        REQUIRE(e.paths.size() == 1);
        const double tolerance = r.number("relative_tolerance");
        CHECK(double{e.paths[0].length_m} == Approx(r.number("distance_m")).epsilon(tolerance));
        CHECK(double{e.paths[0].length_m} / double{e.speed_of_sound_m_s} ==
              Approx(r.number("delay_s")).epsilon(tolerance));
        const json& energy = r.expect.at("energy_per_m2");
        for (std::size_t b = 0; b < kBandCount; ++b) {
            const double want = (energy.is_array() ? energy[b] : energy).get<double>();
            CHECK(e.total(b) == Approx(want).epsilon(tolerance));
        }
    }
}

TEST_CASE("reference: the direct sound of sources with a directivity") {
    const Reference r = reference("directivity");
    aula::Propagation propagation(r.scene, r.scene.simulation);
    aula::FrameInput input;
    input.listeners = {r.scene.listener.pose.position};
    for (const aula::Source& source : r.scene.sources) {
        input.sources.push_back(source.position_at(0));
        input.source_rotations.push_back(source.pose_at(0).rotation());
    }
    propagation.step(input);
    const auto error_db = [&](std::size_t source, const std::string& expected) {
        const auto levels_db = r.expect.at("level_db").at(expected).get<std::vector<double>>();
        const auto& paths = propagation.response(source).paths;
        REQUIRE(paths.size() == 1);
        const double d = double{paths[0].length_m};
        double largest = 0;
        for (std::size_t b = 0; b < kBandCount; ++b) {
            const double level_db =
                10 * std::log10(4 * std::acos(-1.0) * d * d * double{paths[0].energy[b]});
            largest = std::max(largest, std::abs(level_db - levels_db.at(b)));
        }
        return largest;
    };
    for (std::size_t s = 0; s < r.scene.sources.size(); ++s) {
        const std::string& name = r.scene.sources[s].name;
        CAPTURE(name);
        CHECK(error_db(s, name) < r.number("tolerance_db"));
        // Companion: another source of the list.
        CHECK(error_db(s, r.scene.sources[s == 0 ? 1 : s - 1].name) > 1);
    }
}

TEST_CASE("reference: a lossless room's late energy arrives at the rate c / V") {
    const Reference r = reference("lossless_box");
    const EnergyResponse e = response(r.scene, 10, 1000);
    const auto uniform = e.uniform(0.1);
    double late = 0;
    for (std::size_t k = 1; k <= 4; ++k) late += double{uniform[k][4]};
    CHECK(late / 0.4 ==
          Approx(r.number("late_energy_rate_per_m2_s")).epsilon(r.number("relative_tolerance")));
}

TEST_CASE("reference: the 5 x 4 x 3 box's orders") {
    const Reference r = reference("box_5x4x3");
    const auto found = orders(r.scene, 3, 60, 4000, 4);
    for (std::size_t n = 0; n < found.size(); ++n) {
        INFO("order " << n + 1);
        CHECK(found[n].energy ==
              Approx(r.list("order_energy_per_m2")[n]).epsilon(r.tolerance("order_energy")));
        CHECK(found[n].mean_length_m ==
              Approx(r.list("order_mean_length_m")[n]).epsilon(r.tolerance("order_mean_length")));
    }
}

TEST_CASE("reference: the 5 x 4 x 3 box's room-acoustic parameters, and not Eyring's time") {
    const Reference r = reference("box_5x4x3");
    const auto p = aula::room_parameters(response(r.scene, 20, 2000))[4];
    REQUIRE((p.t30_s && p.edt_s && p.c80_db && p.d50 && p.ts_s && p.g_db));
    CHECK(*p.t30_s == Approx(r.number("t30_s")).epsilon(r.tolerance("t30")));
    CHECK(*p.t30_s != Approx(r.number("t_eyring_s")).epsilon(r.tolerance("t30")));
    CHECK(*p.edt_s == Approx(r.number("edt_s")).epsilon(r.tolerance("edt")));
    CHECK(*p.c80_db == Approx(r.number("c80_db")).margin(r.tolerance("c80_db")));
    CHECK(*p.d50 == Approx(r.number("d50")).margin(r.tolerance("d50")));
    CHECK(*p.ts_s == Approx(r.number("ts_s")).margin(r.tolerance("ts_s")));
    CHECK(*p.g_db == Approx(r.number("g_db")).margin(r.tolerance("g_db")));
}

TEST_CASE("reference: every order of the sphere is rho^n 4 / S") {
    const Reference r = reference("sphere");
    for (const std::size_t band : {std::size_t{0}, std::size_t{7}}) {
        const double rho = 1 - double{r.scene.materials.at(0).absorption[band]};
        const auto found = orders(r.scene, 3, 60, 4000, band);
        for (std::size_t n = 0; n < found.size(); ++n) {
            INFO("band " << band << ", order " << n + 1);
            const double want =
                std::pow(rho, double(n + 1)) * r.number("order_energy_rho_1_per_m2");
            CHECK(found[n].energy == Approx(want).epsilon(r.tolerance("order_energy")));
        }
    }
}

TEST_CASE("reference: path lengths in the sphere, source and listener at its centre") {
    const Reference r = reference("sphere_centre");
    const auto found = orders(r.scene, 3, 60, 4000, 0);
    for (std::size_t n = 0; n < found.size(); ++n) {
        INFO("order " << n + 1);
        CHECK(found[n].mean_length_m ==
              Approx(r.list("order_mean_length_m")[n]).epsilon(r.tolerance("order_mean_length")));
        if (n == 0) continue;  // all of one length: the remainder is the width of a time bin
        CHECK(found[n].length_variance_m2 == Approx(r.list("order_length_variance_m2")[n])
                                                 .epsilon(r.tolerance("order_length_variance")));
    }
}

TEST_CASE("reference: the sphere decays at its exact rate, and not at Eyring's") {
    const Reference r = reference("sphere");
    const auto parameters = aula::room_parameters(response(r.scene, 20, 2500));
    for (std::size_t b = 0; b < kBandCount; ++b) {
        INFO("band " << b);
        REQUIRE(parameters[b].t30_s);
        CHECK(*parameters[b].t30_s == Approx(r.list("t_s")[b]).epsilon(r.tolerance("t")));
        CHECK(*parameters[b].t30_s != Approx(r.list("t_eyring_s")[b]).epsilon(r.tolerance("t")));
    }
}

TEST_CASE("reference: boxes decay more slowly than by Eyring's formula") {
    for (const char* name : {"decay_box", "decay_cube"}) {
        const Reference r = reference(name);
        const double tolerance = r.number("relative_tolerance");
        const auto parameters = aula::room_parameters(response(r.scene, 20, 1000));
        for (std::size_t b = 0; b < kBandCount; ++b) {
            INFO(name << ", band " << b);
            REQUIRE(parameters[b].t30_s);
            CHECK(*parameters[b].t30_s == Approx(r.list("t_s")[b]).epsilon(tolerance));
            CHECK(*parameters[b].t30_s != Approx(r.list("t_eyring_s")[b]).epsilon(tolerance));
        }
    }
}

TEST_CASE("reference: the 10 x 8 x 4 box decays as in other engines") {
    for (const char* name : {"box_10x8x4", "noise_box"}) {
        const Reference r = reference(name);
        const auto parameters = aula::room_parameters(response(r.scene, 10, 1000));
        for (std::size_t b = 0; b < kBandCount; ++b) {
            INFO(name << ", band " << b);
            REQUIRE(parameters[b].t30_s);
            CHECK(*parameters[b].t30_s ==
                  Approx(r.list("t30_s")[b]).epsilon(r.number("relative_tolerance")));
        }
    }
}

TEST_CASE("reference: first order at the centre of a cube") {
    const Reference r = reference("cube_center");
    const EnergyResponse e = response(r.scene, 20, 4000);
    for (std::size_t b = 0; b < kBandCount; ++b) {
        CHECK(e.total(b) ==
              Approx(r.list("energy_per_m2")[b]).epsilon(r.number("relative_tolerance")));
    }
}

TEST_CASE("reference: the reflection of a plane, and its course in time") {
    const Reference r = reference("plane");
    const double tolerance = r.number("relative_tolerance");
    const EnergyResponse e = response(r.scene, 20, 4000);
    for (std::size_t b = 0; b < kBandCount; ++b) {
        CHECK(e.total(b) == Approx(r.list("energy_per_m2")[b]).epsilon(tolerance));
    }
    const auto uniform = e.uniform(0.001);
    for (std::size_t i = 0; i < r.list("times_s").size(); ++i) {
        double until = 0;
        const auto end = static_cast<std::size_t>(std::lround(r.list("times_s")[i] * 1000));
        for (std::size_t k = 0; k < end; ++k) until += double{uniform[k][0]};
        INFO("until " << end << " ms");
        CHECK(until == Approx(r.list("energy_until_rho_1_per_m2")[i]).epsilon(tolerance));
    }
}

TEST_CASE("reference: a smooth box has exactly the image sources' arrivals") {
    const Reference r = reference("shoebox_specular");
    const EnergyResponse e = response(r.scene, 1, 100);
    const json& arrivals = r.expect.at("arrivals");
    REQUIRE(e.paths.size() == arrivals.size());
    const double pi = std::acos(-1.0);
    for (std::size_t i = 0; i < arrivals.size(); ++i) {
        const auto row = arrivals[i].get<std::vector<double>>();
        const aula::SoundPath& path = e.paths[i];
        INFO("arrival " << i << " of order " << row[0] << " after " << row[1] << " m");
        CHECK(path.order == static_cast<int>(row[0]));
        CHECK(double{path.length_m} == Approx(row[1]).margin(r.tolerance("length_m")));
        for (int axis = 0; axis < 3; ++axis) {
            CHECK(double{path.direction[axis]} ==
                  Approx(row[static_cast<std::size_t>(axis) + 2]).margin(r.tolerance("direction")));
        }
        for (std::size_t b = 0; b < kBandCount; ++b) {
            const double rho = 1 - double{r.scene.materials.at(0).absorption[b]};
            const double want = std::pow(rho, row[0]) / (4 * pi * row[1] * row[1]);
            CHECK(double{path.energy[b]} == Approx(want).epsilon(r.tolerance("relative_energy")));
        }
    }
    // All of the energy: nothing remains for the rays.
    for (const Bands& energy : e.energy) CHECK(energy == Bands{});
}

TEST_CASE("reference: direct sound bends around a half plane, corners and into a door") {
    for (const char* name : {"half_plane", "corner_270", "corner_300", "corner_210", "door_thin"}) {
        const Reference r = reference(name);
        const auto tolerance_db = [&](bool is_lit) {
            return r.expect.at("tolerance_db").at(is_lit ? "lit" : "shadow").get<double>();
        };
        DirectLevels levels(r.scene);
        Scene without = r.scene;
        without.simulation.diffraction_order = 0;
        DirectLevels straight(without);
        bool is_any_lit = false;
        double straight_error_db = 0;
        double formula_error_db = 0;
        for (const json& c : r.expect.at("cases")) {
            const aula::Vec3 source = point(c.at("source"));
            const aula::Vec3 listener = point(c.at("listener"));
            const bool is_lit = c.at("lit").get<bool>();
            const auto want_db = c.at("level_db").get<std::vector<double>>();
            const std::vector<double> level_db = levels(source, listener);
            INFO(name << ", " << c.at("name"));
            CHECK(largest_difference(level_db, want_db) < tolerance_db(is_lit));
            const double straight_db = largest_difference(straight(source, listener), want_db);
            straight_error_db = std::max(straight_error_db, is_lit ? straight_db : 0);
            is_any_lit = is_any_lit || is_lit;
            if (is_lit) continue;
            // The formula of Kurze and Anderson for barriers.
            double bent_m = 1e9;
            for (const aula::SoundPath& path : levels.paths()) {
                if (path.order == 0) bent_m = std::min(bent_m, double{path.length_m});
            }
            const double detour_m =
                std::max(1e-6, bent_m - double{glm::distance(source, listener)});
            const double x = std::sqrt(4 * std::acos(-1.0) * detour_m * 1000 / 343.2);
            formula_error_db = std::max(
                formula_error_db, std::abs(-5 - 20 * std::log10(x / std::tanh(x)) - want_db[4]));
        }
        // Companions.
        if (is_any_lit) CHECK(straight_error_db > 2 * tolerance_db(true));
        CHECK(formula_error_db > 2 * tolerance_db(false));
    }
}

TEST_CASE("reference: direct sound bends around thick barriers, pillars and round columns") {
    for (const char* name : {"thick_barrier", "high_barrier_10cm", "high_barrier_30cm",
                             "high_barrier_1m", "pillar", "round_column"}) {
        const Reference r = reference(name);
        // All edges of a curved surface count as one bend.
        const int least_order = r.expect.at("least_order").get<int>();
        const auto levels_of_order = [&](int order) {
            Scene scene = r.scene;
            scene.simulation.diffraction_order = order;
            return DirectLevels(scene);
        };
        DirectLevels levels(r.scene);
        DirectLevels least = levels_of_order(least_order);
        DirectLevels below = levels_of_order(least_order - 1);
        double below_error_db = 0;
        for (const json& c : r.expect.at("cases")) {
            const aula::Vec3 source = point(c.at("source"));
            const aula::Vec3 listener = point(c.at("listener"));
            const auto want_db = c.at("level_db").get<std::vector<double>>();
            const auto error_db = [&](DirectLevels& of) {
                std::vector<double> level_db = of(source, listener);
                level_db.resize(want_db.size());
                return largest_difference(level_db, want_db);
            };
            CAPTURE(name, c.at("name").get<std::string>());
            CHECK(error_db(levels) < r.number("tolerance_db"));
            CHECK(error_db(least) < r.number("tolerance_db"));
            below_error_db = std::max(below_error_db, error_db(below));
        }
        CHECK(below_error_db > 2 * r.number("tolerance_db"));
    }
}

TEST_CASE("reference: on walks past a wall, a corner and a door the direct sound never jumps") {
    for (const char* name : {"walk_wall_end", "walk_corner", "walk_door"}) {
        const Reference r = reference(name);
        const auto bound_db = r.list("largest_step_db");
        for (const json& walk : r.expect.at("walks")) {
            const aula::Vec3 source = point(walk.at("source"));
            const aula::Vec3 from = point(walk.at("from"));
            const aula::Vec3 to = point(walk.at("to"));
            const int steps =
                static_cast<int>(std::lround(double{glm::distance(from, to)} / r.number("step_m")));
            for (const int order : {1, 0}) {
                Scene scene = r.scene;
                scene.simulation.diffraction_order = order;
                DirectLevels levels(scene);
                std::vector<double> before;
                double largest = 0;  // step re its bound
                double error_db = 0;
                std::size_t places = 0;
                for (int i = 0; i <= steps; ++i) {
                    const float way = static_cast<float>(i) / static_cast<float>(steps);
                    const aula::Vec3 listener = from + way * (to - from);
                    const std::vector<double> now = levels(source, listener);
                    for (std::size_t b = 0; i > 0 && b < kBandCount; ++b) {
                        largest = std::max(largest, std::abs(now[b] - before[b]) / bound_db[b]);
                    }
                    before = now;
                    for (const json& place : walk.at("places")) {
                        if (glm::distance(point(place.at("listener")), listener) > 1e-4F) continue;
                        ++places;
                        error_db = std::max(
                            error_db, largest_difference(
                                          now, place.at("level_db").get<std::vector<double>>()));
                    }
                }
                CAPTURE(name, source.x, order, largest, error_db);
                CHECK(places == walk.at("places").size());
                CHECK((largest < 1) == (order == 1));
                CHECK((error_db < r.number("tolerance_db")) == (order == 1));
            }
        }
    }
}
