// Sound through walls: energy balance, reciprocity, and equal results of all estimators.

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <vector>

#include "aula/engine/propagation.h"
#include "engine/base/sampling.h"
#include "engine/trace/path_tracer.h"
#include "tests/engine/rooms_in_row.h"
#include "tests/support/measure.h"

using namespace aula;
using aula::test::add_partition;
using aula::test::row_of_rooms;
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

namespace {

/// The highest orders of the paths before and behind walls in a batch.
struct HighestOrders {
    int before = 0;
    int behind = 0;
};

class OrderTracer : public PathTracer {
 public:
    OrderTracer(const RayScene& scene, const SpecularPaths& images, const TraceSettings& settings)
        : PathTracer(scene, images, settings) {}

    HighestOrders of(const Vec3& source, int batch) const {
        constexpr int kAll = 100'000;
        HighestOrders highest;
        follow(
            {0, source}, test::test_seed(), batch, kAll, Paths::all,
            [&](const PathBatch& paths, int order) {
                int& of_paths = paths.behind_walls ? highest.behind : highest.before;
                of_paths = std::max(of_paths, order);
            },
            [](const PathBatch&) {});
        return highest;
    }
};

/// Traces a batch and compares the energy of all paths with what was emitted.
class BalanceTracer : public PathTracer {
 public:
    BalanceTracer(const RayScene& scene, const SpecularPaths& images, const TraceSettings& settings,
                  bool divides = false)
        : PathTracer(scene, images, settings, divides) {}

    /// [order] Energy on the way and heat so far, per emitted energy. The heat is that part of the
    /// absorption which is not transmitted, or all of it.
    std::vector<double> balance(const Vec3& source, int orders, bool all_absorption = false,
                                int batch = 0) const {
        std::vector<double> on_the_way(static_cast<std::size_t>(orders) + 1, 0);
        std::vector<double> heat(static_cast<std::size_t>(orders) + 1, 0);
        follow(
            {0, source}, test::test_seed(), batch, orders, Paths::all,
            [&](const PathBatch& paths, int order) {
                for (std::size_t i = 0; i < paths.count; ++i) {
                    const double energy = double{paths.energy[i][0]};
                    on_the_way[static_cast<std::size_t>(order)] += energy;
                    const std::uint32_t material = scene().surface(paths.hits.triangle[i]).material;
                    heat[static_cast<std::size_t>(order)] +=
                        energy * (double{scene().material(material).absorption[0]} -
                                  (all_absorption ? 0 : double{scene().transmission(material)[0]}));
                }
            },
            [](const PathBatch&) {});
        std::vector<double> balance;
        double lost = 0;
        for (std::size_t n = 0; n < on_the_way.size(); ++n) {
            balance.push_back((on_the_way[n] + lost) / rays_of(1));
            lost += heat[n];
        }
        return balance;
    }
};

}  // namespace

TEST_CASE("paths in the gap between two walls that transmit end as early as others") {
    Scene scene = row_of_rooms(2, 0.1F, 0.5F);
    add_partition(scene, 5, 20);
    add_partition(scene, 5.3F, 20);
    const RayScene rays(scene);
    const SpecularPaths images(rays, 0, 0.5F, 1);
    TraceSettings settings;
    settings.rays = 200 * PathTracer::kBatchRays;
    settings.max_length_m = 2000;
    const OrderTracer tracer(rays, images, settings);
    for (int batch = 0; batch < tracer.batch_count(); ++batch) {
        const HighestOrders highest = tracer.of(scene.sources[0].position, batch);
        CAPTURE(batch, highest.before, highest.behind);
        CHECK(highest.before > 100);
        // Segments in the gap are shorter than elsewhere, at most twice as many.
        CHECK(highest.behind < 2.5 * highest.before);
    }
}

TEST_CASE("all paths behind walls survive with about the root of the energy that is left") {
    struct Tracer : PathTracer {
        Tracer(const RayScene& scene, const SpecularPaths& images, const TraceSettings& settings)
            : PathTracer(scene, images, settings) {}
        using PathTracer::follow;
        using PathTracer::Paths;
    };
    Scene scene = row_of_rooms(2, 0.3F, 0.5F);
    add_partition(scene, 5, 20);
    const RayScene rays(scene);
    const SpecularPaths images(rays, 0, 0.5F, 1);
    TraceSettings settings;
    settings.rays = 400 * PathTracer::kBatchRays;
    settings.max_length_m = 2000;
    const Tracer tracer(rays, images, settings);
    std::array<double, 64> energy{};
    std::array<int, 64> batches{};
    for (int batch = 0; batch < tracer.batch_count(); ++batch) {
        int highest = 0;
        tracer.follow(
            {0, scene.sources[0].position}, test::test_seed(), batch, 63, Tracer::Paths::all,
            [&](const PathBatch& paths, int order) {
                if (!paths.behind_walls || paths.count == 0) return;
                highest = order;
                for (std::size_t i = 0; i < paths.count; ++i) {
                    energy[static_cast<std::size_t>(order)] += double{paths.energy[i].sum()};
                }
            },
            [](const PathBatch&) {});
        for (int order = 0; order <= highest; ++order) ++batches[static_cast<std::size_t>(order)];
    }
    // The decay per reflection, before any path ends.
    REQUIRE(batches[28] == tracer.batch_count());
    const double left = energy[28] / energy[16];
    const double survived = static_cast<double>(batches[56]) / batches[44];
    // The energy of each batch decides, not their mean: the exponent is about 1/2. It would be 1
    // if a share survived that is that of the energy.
    CAPTURE(left, batches[44], batches[56]);
    CHECK(survived > std::pow(left, 0.7));
    CHECK(survived < std::pow(left, 0.3));
}

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
        settings.rays = 80;  // a batch
        settings.max_length_m = 1000;
        // Up to an order at which no path is below -30 dB, where roulette begins.
        const double orders = std::min(19.0, std::log(1e-3) / std::log(1 - double{absorption}));
        const BalanceTracer tracer(rays, images, settings);
        const auto balance = tracer.balance(scene.sources[0].position, static_cast<int>(orders));
        for (std::size_t n = 0; n < balance.size(); ++n) {
            CAPTURE(absorption, reduction_db, n, balance[n]);
            // Rounding of up to 19 products and sums of up to 112 paths.
            CHECK(std::abs(balance[n] - 1) < 1e-6);
        }
        // Companion: if what the partitions transmit were heat as well.
        CHECK(tracer.balance(scene.sources[0].position, static_cast<int>(orders), true).back() >
              1.0001);
    }
}

TEST_CASE("with purely specular paths beside the diffuse ones, energy is kept in the mean") {
    Scene scene = row_of_rooms(3, 0.2F, 0.3F);
    add_partition(scene, 5, 6);
    add_partition(scene, 10, 6);
    const RayScene rays(scene);
    const SpecularPaths images(rays, 0, 0.5F, 1);
    TraceSettings settings;
    settings.rays = 400 * PathTracer::kBatchRays;
    settings.max_length_m = 1000;
    const BalanceTracer tracer(rays, images, settings, true);
    constexpr int kOrders = 12;
    const auto of_batches = [&](bool all_absorption) {
        std::vector<std::vector<double>> balances(kOrders + 1);
        for (int batch = 0; batch < tracer.batch_count(); ++batch) {
            const auto balance =
                tracer.balance(scene.sources[0].position, kOrders, all_absorption, batch);
            for (std::size_t n = 0; n < balance.size(); ++n) balances[n].push_back(balance[n]);
        }
        return balances;
    };
    const auto balances = of_batches(false);
    for (std::size_t n = 0; n < balances.size(); ++n) {
        const test::Estimate e = test::estimate(balances[n]);
        CAPTURE(n, e.mean, e.standard_error);
        // Rounding, as above.
        CHECK(std::abs(e.mean - 1) < test::kFamilyZ * e.standard_error + 1e-6);
        CHECK(e.standard_error < 0.005);
    }
    // Companion: if what the partitions transmit were heat as well.
    const test::Estimate wrong = test::estimate(of_batches(true).back());
    CHECK(wrong.mean - 1 > test::kRefutedZ * wrong.standard_error);
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
        CHECK(propagation.response(0).paths[0].kind == SoundPath::Kind::through_walls);
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
