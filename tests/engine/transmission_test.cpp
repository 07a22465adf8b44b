// Sound through walls: levels, energy balance and reciprocity, for every estimator.

#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <vector>

#include "aula/engine/propagation.h"
#include "aula/engine/scene_file.h"
#include "engine/base/sampling.h"
#include "engine/trace/path_tracer.h"
#include "tests/support/measure.h"
#include "tests/support/rooms.h"
#include "tests/support/statistics.h"

using namespace aula;
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

Object quad(const std::vector<Vec3>& corners, std::uint32_t material) {
    Object object;
    object.vertices = corners;
    object.triangles = {{0, 1, 2}, {0, 2, 3}};
    object.triangle_materials = {material, material};
    return object;
}

Object partition_at(float x_m, std::uint32_t material) {
    return quad({{x_m, 0, 0}, {x_m, 4, 0}, {x_m, 4, 3}, {x_m, 0, 3}}, material);
}

/// A row of rooms of 5 x 4 x 3 m, all of one material; the source is in the first. Partitions are
/// to be added.
Scene row_of_rooms(int count, float absorption, float scattering) {
    Scene scene = test::grey_room(test::box(Vec3(5 * static_cast<float>(count), 4, 3)), absorption,
                                  scattering, Vec3(1.2F, 1.1F, 1.5F), Vec3(7.3F, 2.9F, 1.2F));
    scene.simulation.seed = test::test_seed();
    return scene;
}

/// Adds a partition with a sound reduction, or an opaque one, at x.
void add_partition(Scene& scene, float x_m, std::optional<float> reduction_db) {
    Material material = scene.materials[0];
    material.name = "partition";
    if (reduction_db) material.sound_reduction_db = Bands::filled(*reduction_db);
    scene.materials.push_back(material);
    scene.objects.push_back(
        partition_at(x_m, static_cast<std::uint32_t>(scene.materials.size()) - 1));
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

/// The mean energies of reflected sound in the rooms that begin at the given x, by all frames.
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
        CHECK(std::abs(rest_db(b) - rest_db(1)) < 0.03);
    }
}

TEST_CASE("every estimator gives the same level behind a partition") {
    // dpc-published has no bias where its window is one frame.
    Scene scene = row_of_rooms(2, 0.3F, 0.4F);
    add_partition(scene, 5, 25.0F);
    const std::vector<Vec3> at{Vec3(7.3F, 2.9F, 1.2F), Vec3(8.8F, 1.1F, 2.2F)};
    const auto levels = [&](Estimator estimator, float time_s) {
        Simulation simulation = test::with(scene, estimator, 0.4F, time_s);
        simulation.rays = 2000;
        simulation.specular_order = 2;
        Propagation propagation(scene, simulation, at.size());
        std::vector<double> sums;
        for (int run = 0; run < 16; ++run) {
            propagation.restart(derive_seed(test::test_seed(), run));
            double sum = 0;
            for (int f = 0; f < 2; ++f) {
                propagation.step({.sources = {scene.sources[0].position}, .listeners = at});
                if (time_s > 0 && f == 0) continue;
                for (std::size_t l = 0; l < at.size(); ++l) {
                    sum += test::total(propagation.response(0, l), 3) / (time_s > 0 ? 1 : 2);
                }
            }
            sums.push_back(sum);
        }
        return test::estimate(sums);
    };
    const test::Estimate patch = levels(Estimator::patch, 0.5F);
    CHECK(patch.mean > 0);
    for (const auto& [estimator, time_s] : {std::pair(Estimator::pt, 0.0F),
                                            {Estimator::dpc_published, 0.0F},
                                            {Estimator::dpc, 0.5F}}) {
        const test::Estimate e = levels(estimator, time_s);
        const double error = std::hypot(e.standard_error, patch.standard_error);
        CAPTURE(estimator_name(estimator), e.mean, patch.mean, error);
        // 1 %: the spheres of 0.5 m average over their volume.
        CHECK(std::abs(e.mean - patch.mean) < test::kFamilyZ * error + 0.01 * patch.mean);
        // Companion: 1 dB of sound reduction.
        CHECK(std::abs(e.mean - 1.259 * patch.mean) > test::kRefutedZ * error + 0.01 * patch.mean);
    }
}

TEST_CASE(
    "under a limit of the order, passages of walls count as reflections for every estimator") {
    Scene scene = row_of_rooms(2, 0.3F, 0.4F);
    add_partition(scene, 5, 10.0F);
    const auto level = [&](Estimator estimator, int order) {
        Simulation simulation = test::with(scene, estimator, 0.3F);
        simulation.rays = 4000;
        simulation.order = order;
        Propagation propagation(scene, simulation);
        return test::estimate(test::restarts(
            propagation, scene, 16, 1, [](const EnergyResponse& r) { return test::total(r); }));
    };
    const test::Estimate patch = level(Estimator::patch, 4);
    const test::Estimate pt = level(Estimator::pt, 4);
    CAPTURE(patch.mean, patch.standard_error, pt.mean, pt.standard_error);
    const double error = std::hypot(patch.standard_error, pt.standard_error);
    CHECK(std::abs(pt.mean - patch.mean) < test::kFamilyZ * error + 0.01 * patch.mean);
    // Companion: one order more.
    CHECK(std::abs(level(Estimator::pt, 5).mean - patch.mean) >
          test::kRefutedZ * error + 0.01 * patch.mean);
}

TEST_CASE("without scattering sound through a wall is that of all images, for every estimator") {
    // The partition halves the energy of what passes and reflects nothing. The unfolded path to an
    // image of the source in the room of 10 m passes the partition's images at x = 5 m + 10 m k.
    Scene scene = row_of_rooms(2, 0.2F, 0);
    add_partition(scene, 5, 3.0103F);
    scene.materials[1].absorption = Bands::filled(1);
    scene.simulation.listener_radius_m = 0.4F;
    scene.simulation.rays = 20000;
    const Vec3 source = scene.sources[0].position;
    const Vec3 listener = scene.listener.pose.position;
    const double c = double{scene.medium.speed_of_sound_m_s()};
    constexpr double kEnd_s = 0.035;
    const auto exact = [&](int without_order) {
        const auto image = [&](int axis, double size_m, int n) {
            const double at = double{source[axis]};
            return n % 2 == 0 ? n * size_m + at : (n + 1) * size_m - at;
        };
        double sum = 0;
        for (int i = -6; i <= 6; ++i) {
            for (int j = -10; j <= 10; ++j) {
                for (int k = -12; k <= 12; ++k) {
                    const double x = image(0, 10, i);
                    const double d =
                        std::hypot(x - double{listener.x}, image(1, 4, j) - double{listener.y},
                                   image(2, 3, k) - double{listener.z});
                    const int order = std::abs(i) + std::abs(j) + std::abs(k);
                    if (order == 0 || order == without_order || d > kEnd_s * c) continue;
                    const double passages = std::abs(std::floor((x - 5) / 10) -
                                                     std::floor((double{listener.x} - 5) / 10));
                    sum += std::pow(0.8, order) * std::pow(0.5, passages) /
                           (4 * std::numbers::pi * d * d);
                }
            }
        }
        return sum;
    };
    for (const int specular_order : {0, 3}) {
        scene.simulation.specular_order = specular_order;
        for (const Estimator estimator : {Estimator::pt, Estimator::dpc, Estimator::patch}) {
            Propagation propagation(scene, test::with(scene, estimator, 0.05F, 0.1F));
            const test::Estimate e = test::estimate(
                test::restarts(propagation, scene, 8, 3, [](const EnergyResponse& r) {
                    CHECK(r.paths.empty());  // no image source is behind a wall
                    return test::energy_between(r, 0, kEnd_s);
                }));
            CAPTURE(specular_order, estimator_name(estimator), e.mean, e.standard_error, exact(-1));
            // The sphere of 0.4 m averages 1 / d^2, and moves arrivals across the end: 1 %.
            CHECK(std::abs(e.mean - exact(-1)) <
                  test::kFamilyZ * e.standard_error + 0.01 * exact(-1));
            // Companions: without the first order, which image sources would count, or with the
            // direct sound, which is a separate path; one frame of `pt` cannot tell the latter.
            const auto differs = [&](double wrong) {
                return std::abs(e.mean - wrong) >
                       test::kRefutedZ * e.standard_error + 0.01 * exact(-1);
            };
            const Vec3 offset = source - listener;
            const double direct = 0.5 / (4 * std::numbers::pi) / double{glm::dot(offset, offset)};
            CHECK(differs(exact(1)));
            if (estimator != Estimator::pt) CHECK(differs(exact(-1) + direct));
        }
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

namespace {

/// Traces a batch and compares the energy of all paths with what was emitted.
class BalanceTracer : public PathTracer {
 public:
    BalanceTracer(const RayScene& scene, const SpecularPaths& images, const TraceSettings& settings)
        : PathTracer(scene, images, settings) {}

    /// [order] Energy on the way and heat so far, per emitted energy.
    std::vector<double> balance(const Vec3& source, int orders) const {
        std::vector<double> on_the_way(static_cast<std::size_t>(orders) + 1, 0);
        std::vector<double> heat(static_cast<std::size_t>(orders) + 1, 0);
        follow(
            {0, source}, test::test_seed(), 0, orders, Walls::transmit,
            [&](const PathBatch& paths, int order) {
                for (std::size_t i = 0; i < paths.count; ++i) {
                    const double energy = double{paths.energy[i][0]};
                    on_the_way[static_cast<std::size_t>(order)] += energy;
                    const std::uint32_t material = scene().surface(paths.hits.triangle[i]).material;
                    heat[static_cast<std::size_t>(order)] +=
                        energy * (double{scene().material(material).absorption[0]} -
                                  double{scene().transmission(material)[0]});
                }
            },
            [](const PathBatch&) {});
        std::vector<double> balance;
        double lost = 0;
        for (std::size_t n = 0; n < on_the_way.size(); ++n) {
            balance.push_back((on_the_way[n] + lost) / kBatchRays);
            lost += heat[n];
        }
        return balance;
    }
};

}  // namespace

TEST_CASE("what is neither on the way nor heat has never been emitted") {
    // Grey: bands of different spectra are exact in the mean only.
    struct Case {
        float absorption, scattering, reduction_db;
    };
    for (const auto& [absorption, scattering, reduction_db] :
         {Case{0.2F, 1, 20}, {0.3F, 0.3F, 6}, {0.01F, 0.5F, 20}, {0.5F, 0, 3.1F}}) {
        Scene scene = row_of_rooms(3, absorption, scattering);
        add_partition(scene, 5, reduction_db);
        add_partition(scene, 10, reduction_db);
        const RayScene rays(scene);
        const SpecularPaths images(rays, 0, 0.5F, 1);
        TraceSettings settings;
        settings.rays = PathTracer::kBatchRays;
        settings.max_length_m = 1000;
        // Up to an order at which no path is below -80 dB.
        const auto balance =
            BalanceTracer(rays, images, settings).balance(scene.sources[0].position, 20);
        for (std::size_t n = 0; n < balance.size(); ++n) {
            CAPTURE(absorption, reduction_db, n, balance[n]);
            // Rounding of 20 products and sums of up to 160 paths.
            CHECK(std::abs(balance[n] - 1) < 1e-6);
        }
    }
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
        const SpecularPath& path = propagation.response(0).paths[0];
        CHECK(path.id == SpecularPath::kThroughWalls);
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

TEST_CASE("a door in a partition adds what it transmits") {
    // 10.2 m2 of 50 dB and 1.8 m2 of 25 dB: 33.2 dB. Little absorption, so that the field is even.
    const auto level_difference_db = [](const std::vector<std::pair<Object, float>>& parts) {
        Scene scene = row_of_rooms(2, 0.03F, 1);
        for (const auto& [object, reduction_db] : parts) {
            Material material = scene.materials[0];
            material.sound_reduction_db = Bands::filled(reduction_db);
            const auto index = static_cast<std::uint32_t>(scene.materials.size());
            scene.materials.push_back(material);
            scene.objects.push_back(object);
            for (std::uint32_t& m : scene.objects.back().triangle_materials) m = index;
        }
        Simulation simulation = scene.simulation;
        simulation.rays = 2000;
        simulation.ir_length_s = 4;
        const auto means = room_means(scene, simulation, {0, 5}, 2);
        return decibels(means[0][0] / means[1][0]);
    };
    const auto wall = [](float y0, float y1, float z0, float z1) {
        return quad({{5, y0, z0}, {5, y1, z0}, {5, y1, z1}, {5, y0, z1}}, 0);
    };
    const double parts_db = level_difference_db({{wall(1.5F, 2.4F, 0, 2), 25.0F},
                                                 {wall(0, 1.5F, 0, 3), 50.0F},
                                                 {wall(2.4F, 4, 0, 3), 50.0F},
                                                 {wall(1.5F, 2.4F, 2, 3), 50.0F}});
    const double whole_db = level_difference_db({{partition_at(5, 0), 33.16F}});
    CAPTURE(parts_db, whole_db);
    // The door is not where the mean of the field is: 0.15 dB.
    CHECK(std::abs(parts_db - whole_db) < 0.15);
    // Companion: without the share of the wall, 0.08 dB ... or with the mean of the decibels.
    const double mean_db = level_difference_db({{partition_at(5, 0), 46.25F}});
    CHECK(std::abs(parts_db - mean_db) > 10);
}

TEST_CASE("nothing passes an opaque wall behind a wall that transmits, for every estimator") {
    Scene scene = row_of_rooms(3, 0.2F, 0.5F);
    scene.simulation.direct = true;
    scene.simulation.specular_order = 2;
    add_partition(scene, 5, 10.0F);
    add_partition(scene, 10, std::nullopt);
    for (const Estimator estimator : test::kAllEstimators) {
        Propagation propagation(scene, test::with(scene, estimator, 0.3F));
        const FrameInput input{.sources = {scene.sources[0].position},
                               .listeners = {Vec3(12.5F, 2, 1.4F)}};
        for (int f = 0; f < 3; ++f) propagation.step(input);
        CAPTURE(estimator_name(estimator));
        for (std::size_t b = 0; b < kBandCount; ++b) CHECK(propagation.response(0).total(b) == 0);
        CHECK(propagation.response(0).paths.empty());
        // Companion: in the middle room there is sound.
        const FrameInput before{.sources = input.sources, .listeners = {Vec3(7.5F, 2, 1.4F)}};
        propagation.restart(1);
        propagation.step(before);
        CHECK(propagation.response(0).total(4) > 0);
        REQUIRE(propagation.response(0).paths.size() == 1);
        CHECK(propagation.response(0).paths[0].id == SpecularPath::kThroughWalls);
    }
}

TEST_CASE("a source is audible behind walls that transmit, and not behind an opaque one") {
    // Three separate rooms in a row, 0.1 m apart.
    Scene scene = row_of_rooms(1, 0.2F, 0.5F);
    scene.materials.push_back(scene.materials[0]);
    scene.materials[1].sound_reduction_db = Bands::filled(20);
    scene.objects = {test::box(Vec3(5, 4, 3), 1), test::box(Vec3(5, 4, 3), 1, Vec3(5.1F, 0, 0)),
                     test::box(Vec3(5, 4, 3), 0, Vec3(10.2F, 0, 0))};
    const Propagation propagation(scene, test::with(scene, Estimator::patch, 0.3F));
    for (const auto& [x_m, audible] : {std::pair(2.0F, 1), {7.5F, 1}, {12.5F, 0}}) {
        CAPTURE(x_m);
        CHECK(propagation.sources_connected(
                  {.sources = {scene.sources[0].position}, .listeners = {Vec3(x_m, 2, 1.4F)}}) ==
              std::vector<char>{static_cast<char>(audible)});
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
}

namespace {

constexpr int kRestarts = 16;

using Figures = std::vector<std::vector<double>>;

void read(const EnergyResponse& response, Figures& figures) {
    std::size_t figure = 0;
    for (const auto& [begin_s, end_s] : {std::pair(0.0, 0.03), {0.03, 0.06}, {0.06, 0.25}}) {
        for (const std::size_t band : {0U, 3U, 5U, 7U}) {
            if (figures.size() <= figure) figures.emplace_back();
            figures[figure++].push_back(test::energy_between(response, begin_s, end_s, band));
        }
    }
}

/// The response of a scene by rays from the source or, after the source has jumped, from the
/// listener.
Figures figures_of(const Scene& scene, bool from_listener) {
    Simulation simulation = test::with(scene, Estimator::patch, 0.25F);
    simulation.rays = 500;
    simulation.specular_order = 1;
    Propagation propagation(scene, simulation);
    Figures figures;
    constexpr int kMoves = 3;
    for (int run = 0; run < kRestarts; ++run) {
        propagation.restart(derive_seed(test::test_seed(), run, from_listener ? 1 : 0));
        FrameInput input = test::static_input(scene);
        const Vec3 position = input.sources[0];
        for (int f = 0; f <= kMoves; ++f) {
            if (from_listener) {
                input.sources[0] =
                    f < kMoves ? Vec3(0.5F, 0.5F + static_cast<float>(f), 2.5F) : position;
            }
            propagation.step(input);
        }
        read(propagation.response(0), figures);
    }
    return figures;
}

double largest_distance(const Figures& a, const Figures& b) {
    double largest = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        const test::Estimate x = test::estimate(a[i]);
        const test::Estimate y = test::estimate(b[i]);
        largest = std::max(
            largest, std::abs(x.mean - y.mean) / std::hypot(x.standard_error, y.standard_error));
    }
    return largest;
}

}  // namespace

TEST_CASE("rays from either end give the same sound through walls of one face and of two") {
    for (const bool two_faces : {false, true}) {
        Scene scene = row_of_rooms(2, 0.25F, 0.5F);
        scene.materials[0].scattering = {{0.1F, 0.3F, 0.5F, 1, 0.7F, 0, 0.9F, 0.6F}};
        add_partition(scene, 4.9F, 15.0F);
        scene.materials[1].sound_reduction_db = {{10, 12, 15, 20, 30, 40, 50, 20}};
        scene.materials[1].scattering = {{0.2F, 0.3F, 0.5F, 1, 0.7F, 0, 0.9F, 0.6F}};
        if (two_faces) {
            add_partition(scene, 5.1F, 15.0F);
            scene.materials[2].sound_reduction_db = {{12, 12, 12, 20, 30, 40, 50, 20}};
        }
        const Figures source = figures_of(scene, false);
        const Figures listener = figures_of(scene, true);
        CAPTURE(two_faces);
        CHECK(largest_distance(source, listener) < test::kFamilyZ);
        // Companion: a sound reduction of 2 dB more.
        for (std::size_t m = 1; m < scene.materials.size(); ++m) {
            for (float& r : scene.materials[m].sound_reduction_db->value) r += 2;
        }
        CHECK(largest_distance(source, figures_of(scene, true)) > test::kRefutedZ);
    }
}

TEST_CASE("sound through walls is the same to the bit with any number of threads") {
    Scene scene = row_of_rooms(2, 0.2F, 0.4F);
    scene.simulation.direct = true;
    add_partition(scene, 5, 8.0F);
    for (const Estimator estimator : test::kAllEstimators) {
        Simulation simulation = test::with(scene, estimator, 0.3F);
        Propagation one(scene, simulation);
        simulation.threads = 3;
        Propagation three(scene, simulation);
        for (int f = 0; f < 3; ++f) {
            one.step(test::static_input(scene));
            three.step(test::static_input(scene));
        }
        CAPTURE(estimator_name(estimator));
        CHECK(test::same_bits(one.response(0), three.response(0)));
    }
}

TEST_CASE("transmission costs nothing and changes nothing where no surface transmits") {
    Scene opaque = row_of_rooms(2, 0.2F, 0.4F);
    add_partition(opaque, 5, std::nullopt);
    opaque.simulation.direct = true;
    Scene unused = opaque;
    unused.materials.push_back(opaque.materials[0]);
    unused.materials.back().sound_reduction_db = Bands::filled(10);
    Scene transmits = opaque;
    transmits.materials[1].sound_reduction_db = Bands::filled(10);
    for (const Estimator estimator : test::kAllEstimators) {
        CAPTURE(estimator_name(estimator));
        Simulation simulation = test::with(opaque, estimator, 0.3F);
        Propagation a(opaque, simulation);
        Propagation b(unused, simulation);
        Propagation c(transmits, simulation);
        simulation.transmission = false;
        Propagation d(transmits, simulation);
        const FrameInput input{.sources = {opaque.sources[0].position},
                               .listeners = {Vec3(3.4F, 2.2F, 1.6F)}};
        for (int f = 0; f < 3; ++f) {
            for (Propagation* p : {&a, &b, &c, &d}) p->step(input);
        }
        CHECK(test::same_bits(a.response(0), b.response(0)));
        CHECK(test::same_bits(a.response(0), d.response(0)));
        CHECK(a.statistics().segments == b.statistics().segments);
        CHECK(a.statistics().segments == d.statistics().segments);
        // Companion: a partition that transmits.
        CHECK_FALSE(test::same_bits(a.response(0), c.response(0)));
        CHECK(a.statistics().segments < c.statistics().segments);
    }
}

TEST_CASE("a material that begins to transmit is heard, and not after it has become opaque again") {
    Scene scene = row_of_rooms(2, 0.2F, 0.5F);
    add_partition(scene, 5, std::nullopt);
    scene.simulation.direct = true;
    for (const bool whole_object : {false, true}) {
        Propagation propagation(scene, test::with(scene, Estimator::patch, 0.3F, 0.1F));
        const FrameInput input = test::static_input(scene);
        const auto heard = [&] {
            for (int f = 0; f < 4; ++f) propagation.step(input);
            return propagation.response(0).total(2) > 0;
        };
        Material thin = scene.materials[1];
        thin.sound_reduction_db = Bands::filled(12);
        const auto set = [&](const Material& material) {
            if (whole_object) {
                propagation.set_object_material(1, material);
            } else {
                propagation.change_material(1, material);
            }
        };
        CAPTURE(whole_object);
        CHECK_FALSE(heard());
        set(thin);
        CHECK(heard());
        set(scene.materials[1]);
        CHECK_FALSE(heard());
    }
}

TEST_CASE("a wall that begins to transmit opens a room in which nothing was before") {
    Scene scene = row_of_rooms(2, 0.2F, 1);
    add_partition(scene, 5, std::nullopt);
    Scene thin = scene;
    thin.materials[1].sound_reduction_db = Bands::filled(10);
    // At construction source and listener are in the first room.
    scene.listener.pose.position = thin.listener.pose.position = Vec3(3.4F, 2.2F, 1.6F);
    const Simulation simulation = test::with(scene, Estimator::patch, 0.3F);
    const FrameInput behind{.sources = {scene.sources[0].position},
                            .listeners = {Vec3(7.3F, 2.9F, 1.2F)}};
    for (const bool whole_object : {false, true}) {
        Propagation changed(scene, simulation);
        Propagation from_start(thin, simulation);
        for (Propagation* p : {&changed, &from_start}) {
            if (whole_object) {
                p->set_object_material(1, thin.materials[1]);
            } else {
                p->change_material(1, thin.materials[1]);
            }
            p->step(behind);
        }
        CAPTURE(whole_object);
        CHECK(from_start.response(0).total(4) > 0);
        CHECK(test::same_bits(changed.response(0), from_start.response(0)));
    }
}

TEST_CASE("nothing passes an opaque partition of one face, oblique or smaller than four patches") {
    // Larger than the room's section, so that no ray passes at its rim.
    const Object oblique = quad(
        {{3.9F, -0.2F, -0.1F}, {6.1F, 4.2F, -0.1F}, {6.1F, 4.2F, 3.1F}, {3.9F, -0.2F, 3.1F}}, 1);
    for (const auto& [partition, patch_size_m] :
         {std::pair(oblique, 0.5F), {partition_at(5, 1), 1.9F}}) {
        CAPTURE(patch_size_m);
        Scene scene = row_of_rooms(2, 0.2F, 0.5F);
        add_partition(scene, 5, std::nullopt);
        scene.objects.back() = partition;
        scene.simulation.patch_size_m = patch_size_m;
        const FrameInput behind = test::static_input(scene);
        FrameInput before = behind;
        before.listeners = {Vec3(3.1F, 2.4F, 1.4F)};
        Propagation propagation(scene, test::with(scene, Estimator::patch, 0.3F));
        const auto level = [&](const FrameInput& input) {
            double sum = 0;
            for (int f = 0; f < 3; ++f) {
                propagation.step(input);
                sum += test::total(propagation.response(0), 4);
            }
            return sum;
        };
        CHECK(level(behind) == 0);
        CHECK(level(before) > 0);
    }
}

TEST_CASE("an oblique partition of one face transmits as much as by path tracing") {
    Scene scene = row_of_rooms(2, 0.3F, 0.4F);
    add_partition(scene, 5, 25.0F);
    scene.objects.back() = quad(
        {{3.9F, -0.2F, -0.1F}, {6.1F, 4.2F, -0.1F}, {6.1F, 4.2F, 3.1F}, {3.9F, -0.2F, 3.1F}}, 1);
    const auto level = [&](Estimator estimator) {
        Simulation simulation = test::with(scene, estimator, 0.4F);
        simulation.rays = 4000;
        Propagation propagation(scene, simulation);
        return test::estimate(test::restarts(
            propagation, scene, 16, 2, [](const EnergyResponse& r) { return test::total(r); }));
    };
    const test::Estimate patch = level(Estimator::patch);
    const test::Estimate pt = level(Estimator::pt);
    const double error = std::hypot(patch.standard_error, pt.standard_error);
    CAPTURE(patch.mean, patch.standard_error, pt.mean, pt.standard_error);
    // 1 %: the sphere of 0.5 m averages over its volume.
    CHECK(std::abs(pt.mean - patch.mean) < test::kFamilyZ * error + 0.01 * pt.mean);
    // Companion: 1 dB of sound reduction.
    CHECK(std::abs(1.259 * pt.mean - patch.mean) > test::kRefutedZ * error + 0.01 * pt.mean);
}
