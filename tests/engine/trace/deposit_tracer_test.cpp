#include "engine/trace/deposit_tracer.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <glm/geometric.hpp>
#include <set>
#include <utility>
#include <vector>

#include "engine/trace/arrival_tracer.h"
#include "tests/support/rooms.h"
#include "tests/support/statistics.h"

using namespace aula;

namespace {

const Vec3 kSource(1.2F, 1.1F, 1.5F);

/// Both tracers in a box, without image sources.
struct TracedBox {
    Scene scene;
    RayScene rays{scene};
    WorkerPool workers{1};
    TimeBins bins{0.5};
    PatchGrid grid{rays, 0.5F, {&kSource, 1}, 1, workers};
    PatchSubdivision subdivision{rays, 0.5F};
    SpecularPaths none{rays, 0, 0.5F, 1};
    TraceSettings settings;

    TracedBox(float absorption, float scattering)
        : scene(test::grey_room(test::box(Vec3(5, 4, 3)), absorption, scattering, kSource,
                                Vec3(3.7F, 2.9F, 1.2F))) {
        settings.rays = 80;  // a batch
        settings.max_length_m = 100;
    }

    DepositTracer deposit_tracer() const { return {rays, grid, bins, none, settings}; }
    ArrivalTracer arrival_tracer() const { return {rays, subdivision, none, settings}; }

    DepositBatch deposits() const {
        DepositBatch batch;
        deposit_tracer().trace({0, kSource}, test::test_seed(), 0, batch);
        return batch;
    }
    ArrivalBatch arrivals() const {
        ArrivalBatch batch;
        arrival_tracer().trace({0, kSource}, {}, test::test_seed(), 0, batch);
        return batch;
    }
};

std::vector<Deposit> all_of(const DepositParts& parts) {
    std::vector<Deposit> all;
    for (const auto& part : parts.part) all.insert(all.end(), part.begin(), part.end());
    return all;
}

/// True if the first batch's segments are those of the second, in order.
bool same_segments(const TraceBatch& a, const TraceBatch& b) {
    if (a.segments.size() != b.segments.size()) return false;
    for (std::size_t i = 0; i < a.segments.size(); ++i) {
        if (a.segments[i].origin != b.segments[i].origin ||
            a.segments[i].direction != b.segments[i].direction ||
            a.segments[i].before_m != b.segments[i].before_m ||
            a.segment_energies[i].energy != b.segment_energies[i].energy) {
            return false;
        }
    }
    return true;
}

}  // namespace

TEST_CASE("every reflection in a lossless Lambert box deposits the whole energy of its ray") {
    const DepositBatch batch = TracedBox(0, 1).deposits();
    const std::vector<Deposit> all = all_of(batch.deposits);
    // Each path ends with a segment that is cut off at the greatest length.
    CHECK(all.size() == batch.segment_count - batch.departures.size());
    CHECK(all.size() > 20 * batch.departures.size());
    for (const Deposit& deposit : all) {
        // Energies of about 1 have mantissas of 2^14.
        REQUIRE(std::abs(double{deposit.energy()[0]} - 1) <= 0x1p-14);
        REQUIRE(deposit.ray < batch.departures.size());
    }
}

TEST_CASE("the deposits of a ray are its energy times (1 - alpha) s at each reflection") {
    // The sum over all reflections is s (1 - alpha) / alpha; 100 m are more than 25 reflections,
    // after which 0.75^25 = 8e-4 of it is left.
    double sum = 0;
    const DepositBatch batch = TracedBox(0.25F, 1).deposits();
    for (const Deposit& deposit : all_of(batch.deposits)) {
        sum += double{deposit.energy()[3]};
    }
    CHECK(sum / static_cast<double>(batch.departures.size()) == Approx(3).epsilon(1e-3));
}

TEST_CASE("both tracers follow the same mirror rays and collect the same specular segments") {
    TracedBox box(0.1F, 0);
    const std::vector<Ray> rays = box.arrival_tracer().rays({0, kSource}, test::test_seed(), 0);
    const std::vector<Ray> again = box.deposit_tracer().rays({0, kSource}, test::test_seed(), 0);
    REQUIRE(rays.size() == again.size());
    for (std::size_t i = 0; i < rays.size(); ++i) {
        REQUIRE(rays[i].origin == again[i].origin);
        REQUIRE(rays[i].direction == again[i].direction);
    }
    const ArrivalBatch arrivals = box.arrivals();
    CHECK(arrivals.segment_count == rays.size());
    CHECK(arrivals.segments.size() > 50);
    CHECK(arrivals.segment_identifiers.size() == arrivals.segments.size());
    CHECK(same_segments(arrivals, box.deposits()));
    // The companion: under a limit of the order gather rays do not continue at mirrors, so the rays
    // bring what ends in a mirror after a diffuse reflection, too.
    TracedBox half(0.1F, 0.5F);
    half.settings.order = 3;
    const DepositBatch limited = half.deposits();
    CHECK(limited.segments.size() > 3 * limited.departures.size());
    CHECK_FALSE(same_segments(half.arrivals(), limited));
}

TEST_CASE("Under a limit of the order only segments that leave a mirror are collected") {
    // Gathers find what leaves a diffuse reflection, and image sources the direct sound.
    TracedBox diffuse(0.1F, 1);
    diffuse.settings.order = 3;
    CHECK(diffuse.deposits().segments.empty());
    // The companion: half of the reflections are specular.
    TracedBox half(0.1F, 0.5F);
    half.settings.order = 3;
    CHECK(half.deposits().segments.size() > half.deposits().departures.size());
}

TEST_CASE("The deposits of a ray are those of its reflections, in the open as in a closed room") {
    // Without the ceiling rays escape after some reflections, and others take their lanes.
    const Vec3 size(5, 4, 3);
    Object object = test::box(size);
    std::erase_if(object.triangles, [&](const std::array<std::uint32_t, 3>& t) {
        return std::all_of(t.begin(), t.end(),
                           [&](std::uint32_t v) { return object.vertices[v].z == size.z; });
    });
    object.triangle_materials.resize(object.triangles.size());
    const Scene scene = test::grey_room(object, 0, 1, kSource, kSource);
    const RayScene rays(scene);
    WorkerPool workers(1);
    const TimeBins bins(0.5);
    const PatchGrid grid(rays, 0.5F, {&kSource, 1}, 1, workers);
    const SpecularPaths none(rays, 0, 0.5F, 1);
    TraceSettings settings;
    settings.rays = 80;
    settings.max_length_m = 100;
    const DepositTracer tracer(rays, grid, bins, none, settings);
    REQUIRE(tracer.batch_count() == 1);
    DepositBatch batch;
    tracer.trace({0, kSource}, test::test_seed(), 0, batch);

    // Ray and time bin of all reflections, from the points of the paths.
    std::multiset<std::pair<std::size_t, std::size_t>> expected;
    const auto lines = tracer.lines({0, kSource}, test::test_seed(), settings.rays, 1000);
    REQUIRE(lines.size() == static_cast<std::size_t>(settings.rays));
    for (std::size_t ray = 0; ray < lines.size(); ++ray) {
        float length_m = 0;
        for (std::size_t k = 1; k < lines[ray].points.size(); ++k) {
            const Vec3& p = lines[ray].points[k];
            length_m += glm::distance(lines[ray].points[k - 1], p);
            const float to_wall_m = std::min({p.x, size.x - p.x, p.y, size.y - p.y, p.z});
            if (std::abs(to_wall_m) > 1e-3F || p.z > size.z) continue;  // in the open
            expected.emplace(ray, bins.index(double{length_m / settings.speed_of_sound_m_s}));
        }
    }
    std::size_t wrong = 0;
    const std::vector<Deposit> all = all_of(batch.deposits);
    for (const Deposit& deposit : all) {
        const auto found = expected.find({deposit.ray, deposit.bin});
        if (found == expected.end()) {
            ++wrong;
        } else {
            expected.erase(found);
        }
    }
    CHECK(all.size() > 3 * lines.size());
    // The points are 0.1 mm off the walls: a reflection in a thousand bins of 0.34 m lies so near
    // the border of its bin.
    CHECK(wrong <= all.size() / 100);
    CHECK(expected.size() <= all.size() / 100);
}

TEST_CASE("The energy of a deposit has 15 bits in the strongest band") {
    double worst = 0;
    for (int i = 0; i < 4000; ++i) {
        const double energy = std::pow(10.0, 4 - i * 0.002);
        Deposit deposit;
        // Rounded down.
        deposit.set_energy(load_bands(Bands::filled(static_cast<float>(energy))), 0);
        const double stored = double{deposit.energy()[3]};
        CHECK(stored <= energy * (1 + 1e-7));
        worst = std::max(worst, 1 - stored / energy);
    }
    // Mantissas from 2^14 on; half of them are larger.
    CHECK(worst < 0x1p-14);
    CHECK(worst > 0x1p-15);
}

TEST_CASE(
    "Lines of paths have a point per reflection, and one in the open unless they end before") {
    // A floor in the open.
    const Vec3 source(0, 0, 1);
    Object floor;
    floor.vertices = {{-1e3F, -1e3F, 0}, {1e3F, -1e3F, 0}, {0, 1e3F, 0}};
    floor.triangles = {{0, 1, 2}};
    floor.triangle_materials = {0};
    const Scene scene = test::grey_room(floor, 0.1F, 0, source, source);
    const RayScene rays(scene);
    const PatchSubdivision subdivision(rays, 100);
    const SpecularPaths none(rays, 0, 0.5F, 1);
    TraceSettings settings;
    settings.rays = 1000;
    settings.max_length_m = 100;
    const ArrivalTracer tracer(rays, subdivision, none, settings);
    for (const int order : {1, 2}) {
        std::size_t down = 0;
        for (const PathLine& line : tracer.lines({0, source}, 1, 200, order)) {
            REQUIRE(line.points.size() == line.energy.size());
            const bool reflected = line.points.at(1).z < 0.5F;
            down += reflected ? 1 : 0;
            // The source, the floor, and the open only where the order leaves a segment.
            CHECK(line.points.size() == (reflected && order > 1 ? 3 : 2));
        }
        // Half of the directions; nearly horizontal ones are too long.
        CHECK(down > 85);
        CHECK(down < 115);
    }
}
