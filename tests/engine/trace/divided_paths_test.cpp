#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "engine/trace/arrival_tracer.h"
#include "engine/trace/deposit_tracer.h"
#include "tests/support/rooms.h"
#include "tests/support/statistics.h"

namespace divided_paths_test {

using namespace aula;

namespace {

const Vec3 kSource(1.2F, 1.1F, 1.5F);

/// A box whose scattering and absorption differ from band to band; without image sources.
struct ColouredBox {
    Scene scene;
    RayScene rays;
    WorkerPool workers{1};
    TimeBins bins{0.5};
    PatchGrid grid{rays, 0.5F, {&kSource, 1}, 1, workers};
    PatchSubdivision subdivision{rays, 0.5F};
    SpecularPaths none{rays, 0, 0.5F, 1};
    TraceSettings settings;

    ColouredBox() : scene(room()), rays(scene) {
        settings.rays = 32 * PathTracer::kBatchRays;
        settings.max_length_m = 100;
    }

    static Scene room() {
        Scene scene =
            test::grey_room(test::box(Vec3(5, 4, 3)), 0, 0, kSource, Vec3(3.7F, 2.9F, 1.2F));
        for (std::size_t b = 0; b < kBandCount; ++b) {
            scene.materials[0].scattering[b] = 0.1F + 0.1F * static_cast<float>(b);
            scene.materials[0].absorption[b] = 0.3F - 0.04F * static_cast<float>(b);
        }
        return scene;
    }

    double scattering(std::size_t band) const {
        return double{scene.materials[0].scattering[band]};
    }
    double reflected(std::size_t band) const {
        return 1 - double{scene.materials[0].absorption[band]};
    }

    DepositBatch deposits(int batch) const {
        const DepositTracer tracer(rays, grid, bins, none, settings);
        DepositBatch out;
        tracer.trace({0, kSource}, test::test_seed(), batch, out);
        return out;
    }

    /// The sum of a band's deposits of a batch, per ray.
    double deposited(int batch, std::size_t band) const {
        const DepositBatch all = deposits(batch);
        double sum = 0;
        for (const auto& part : all.deposits.part) {
            for (const Deposit& deposit : part) sum += double{deposit.energy()[band]};
        }
        return sum / PathTracer::kBatchRays;
    }
};

/// Records the purely specular segments of a batch.
class SpecularTracer : public PathTracer {
 public:
    SpecularTracer(const RayScene& scene, const SpecularPaths& images,
                   const TraceSettings& settings, bool divides)
        : PathTracer(scene, images, settings, divides) {}

    /// [order][ray] The segment of each ray; without length where a ray has none.
    std::vector<std::vector<Ray>> segments(int orders) const {
        std::vector<std::vector<Ray>> all(static_cast<std::size_t>(orders) + 1,
                                          std::vector<Ray>(kBatchRays, Ray{Vec3(0), Vec3(0), 0}));
        follow(
            {0, kSource}, test::test_seed(), 0, orders, Paths::all,
            [&](const PathBatch& paths, int order) {
                for (std::size_t i = 0; i < paths.count; ++i) {
                    if (paths.diffuse[i] != 0) continue;
                    Ray& ray = all[static_cast<std::size_t>(order)][paths.ray[i]];
                    CHECK(ray.max_m == 0);  // the only one
                    ray = {paths.rays.origin.at(i), paths.rays.direction.at(i),
                           paths.rays.max_m[i]};
                }
            },
            [](const PathBatch&) {});
        return all;
    }
};

}  // namespace

TEST_CASE("purely specular paths go where those of a room of mirrors go") {
    ColouredBox box;
    // At order 4 every path is above -30 dB, where roulette begins.
    constexpr int kOrders = 4;
    const auto of_room = [&](float scattering, bool divides) {
        box.scene.materials[0].absorption = Bands::filled(0.1F);
        box.scene.materials[0].scattering = Bands::filled(scattering);
        const RayScene rays(box.scene);
        return SpecularTracer(rays, box.none, box.settings, divides).segments(kOrders);
    };
    const auto mirrors = of_room(0, false);
    const auto divided = of_room(0.7F, true);
    const auto chosen = of_room(0.7F, false);  // companion
    for (std::size_t order = 0; order < mirrors.size(); ++order) {
        int others = 0;
        int missing = 0;
        for (std::size_t ray = 0; ray < PathTracer::kBatchRays; ++ray) {
            const Ray& a = mirrors[order][ray];
            const Ray& b = divided[order][ray];
            const bool same =
                a.origin == b.origin && a.direction == b.direction && a.max_m == b.max_m;
            others += same ? 0 : 1;
            missing += chosen[order][ray].max_m == 0 ? 1 : 0;
        }
        CAPTURE(order);
        CHECK(others == 0);
        if (order > 0) CHECK(missing > PathTracer::kBatchRays / 2);
    }
}

TEST_CASE("each ray has a purely specular path of exact energy, whatever lobes are chosen") {
    ColouredBox box;
    box.settings.order = 4;
    const auto wrong = [&](const TraceBatch& batch) {
        // Ordered by reflection. Under a limit of the order the segments include those that end in
        // a mirror after a diffuse reflection; these have other energies.
        int exact = 0;
        for (const SegmentEnergy& segment : batch.segment_energies) {
            for (int order = 1; order <= box.settings.order; ++order) {
                bool equal = true;
                for (std::size_t b = 0; b < kBandCount; ++b) {
                    const double energy =
                        std::pow(box.reflected(b) * (1 - box.scattering(b)), order);
                    equal &= std::abs(double{segment.energy[b]} - energy) < 1e-5 * energy;
                }
                exact += equal ? 1 : 0;
            }
        }
        return box.settings.order * PathTracer::kBatchRays - exact;
    };
    CHECK(wrong(box.deposits(0)) == 0);
    // Companion: paths of one lobe that is chosen at random.
    ArrivalBatch chosen;
    ArrivalTracer(box.rays, box.subdivision, box.none, box.settings)
        .trace({0, kSource}, {}, test::test_seed(), 0, chosen);
    CHECK(wrong(chosen) > 3 * PathTracer::kBatchRays);
}

TEST_CASE("the diffuse energy of each order is exact in the mean, in every band") {
    ColouredBox box;
    const int batches = box.settings.rays / PathTracer::kBatchRays;
    const auto of_orders = [&](int last) {
        box.settings.order = last;
        std::vector<std::vector<double>> sums(kBandCount);
        for (std::size_t b = 0; b < kBandCount; ++b) {
            for (int k = 0; k < batches; ++k) sums[b].push_back(box.deposited(k, b));
        }
        return sums;
    };
    std::vector<std::vector<double>> before(kBandCount, std::vector<double>(32, 0.0));
    for (int order = 1; order <= 5; ++order) {
        const std::vector<std::vector<double>> now = of_orders(order);
        for (std::size_t b = 0; b < kBandCount; ++b) {
            std::vector<double> of_order;
            for (std::size_t k = 0; k < now[b].size(); ++k)
                of_order.push_back(now[b][k] - before[b][k]);
            const test::Estimate e = test::estimate(of_order);
            // A ray that has met n - 1 mirrors or none deposits s (1 - alpha)^n in the mean.
            const double exact = box.scattering(b) * std::pow(box.reflected(b), order);
            CAPTURE(order, b, exact, e.mean, e.standard_error);
            // Rounding of deposits and of sums in single precision.
            CHECK(std::abs(e.mean - exact) < test::kFamilyZ * e.standard_error + 1e-4 * exact);
            CHECK(e.standard_error < 0.05 * exact);  // so that the check is significant
        }
        before = now;
    }
}

TEST_CASE("surfaces without a diffuse or without a specular lobe divide no path") {
    ColouredBox box;
    const auto same_rays = [&] {
        const RayScene rays(box.scene);
        const ArrivalTracer arrivals(rays, box.subdivision, box.none, box.settings);
        const DepositTracer deposits(rays, box.grid, box.bins, box.none, box.settings);
        const std::vector<Ray> one = arrivals.rays({0, kSource}, test::test_seed(), 0);
        const std::vector<Ray> all = deposits.rays({0, kSource}, test::test_seed(), 0);
        return one.size() == all.size();
    };
    CHECK_FALSE(same_rays());  // companion
    for (const float scattering : {0.0F, 1.0F}) {
        CAPTURE(scattering);
        box.scene.materials[0].scattering = Bands::filled(scattering);
        CHECK(same_rays());
    }
}

}  // namespace divided_paths_test
