#include "engine/estimate/final_gather.h"

#include <algorithm>
#include <array>
#include <bit>
#include <catch2/catch.hpp>
#include <cmath>
#include <glm/geometric.hpp>
#include <random>
#include <vector>

#include "engine/base/worker_pool.h"
#include "tests/engine/rooms_in_row.h"
#include "tests/support/rooms.h"
#include "tests/support/statistics.h"

using namespace aula;

namespace {

constexpr float kSpeed_m_s = 343.2F;
constexpr int kRays = 4;

using Moments = std::array<double, 8>;

Moments numbers(const DirectionMoments& m) {
    const auto floats = std::bit_cast<std::array<float, 8>>(m);
    Moments moments{};
    std::copy(floats.begin(), floats.end(), moments.begin());
    return moments;
}

void add_weighted(double weight, const DirectionMoments& directions, Moments& sum) {
    const Moments moments = numbers(directions);
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += weight * moments[i];
}

/// Adds 0.7 times the energy of a cache at the hits to a response, on two threads.
void add_gathered(const std::vector<GatherHit>& hits, const PatchCache& cache,
                  EnergyResponse& response) {
    WorkerPool workers(2);
    GatheredEnergy gathered(response, 8);
    gathered.add(hits, cache, 0.7);
    workers.run(gathered.part_count(), [&](std::size_t part) { gathered.sum(part); });
}

/// A room with the grid of its patches.
struct Room {
    Vec3 inside{3, 2, 1.5F};
    Scene scene;
    RayScene rays;
    WorkerPool workers{3};
    PatchGrid grid;

    explicit Room(float scattering, float patch_size_m = 0.5F)
        : scene(test::grey_room(test::box(Vec3(8, 6, 4)), 0.1F, scattering, inside, inside)),
          rays(scene),
          grid(rays, patch_size_m, {&inside, 1}, 1, workers) {}
};

void trace_all(FinalGather& gather) {
    for (std::size_t batch = 0; batch < gather.batch_count(); ++batch) gather.trace(batch);
}

/// Rows of patches with random energies in all bins of all bands, and the departures of listeners.
struct Rows {
    TimeBins bins;
    PatchCache cache;
    DepositBatch batch;  // the input of the cache

    Rows(const TimeBins& time_bins, std::uint32_t patches, bool directed)
        : bins(time_bins), cache(bins.count(), directed) {
        std::mt19937_64 random(test::test_seed());
        std::uniform_real_distribution<float> uniform(0, 1);
        for (int ray = 0; ray < kRays; ++ray) {
            const Vec3 v(uniform(random) - 0.5F, uniform(random) - 0.5F, uniform(random));
            batch.departures.push_back(glm::normalize(v));
        }
        for (std::uint32_t patch = 0; patch < patches; ++patch) {
            for (std::size_t bin = 0; bin < bins.count(); ++bin) {
                Deposit deposit;
                deposit.patch = patch;
                deposit.bin = static_cast<std::uint16_t>(bin);
                deposit.ray = static_cast<std::uint8_t>(random() % kRays);
                Bands energy;
                for (float& e : energy.value) e = uniform(random);
                deposit.set_energy(load_bands(energy), 0.5F);
                batch.deposits.add(deposit);
            }
        }
        fill_cache(patches);
    }

    void fill_cache(std::uint32_t patches) {
        cache.begin_add(kRays, patches);
        for (std::size_t part = 0; part < DepositParts::kCount; ++part)
            cache.add_part({&batch, 1}, part);
    }

    /// The result by definition: the energy of each bin, uniform in time, delayed by the hit's
    /// length.
    EnergyResponse expected(const std::vector<GatherHit>& hits, double share) const {
        std::vector<std::array<double, kBandCount>> energy(bins.count());
        std::vector<Moments> directions(bins.count());
        const std::size_t late_bin = bins.index(0.512);
        for (const GatherHit& hit : hits) {
            const auto& deposits = batch.deposits.part[DepositParts::part_of(hit.patch)];
            const bool has_late = hit.late;
            // The weight of a listener's directions is that of the row's spectrum.
            std::array<double, kBandCount> row{};
            for (const Deposit& d : deposits) {
                if (d.patch != hit.patch) continue;
                for (std::size_t b = 0; b < kBandCount; ++b) row[b] += double{d.energy()[b]};
            }
            double weighted = 0;
            double all = 0;
            for (std::size_t b = 0; b < kBandCount; ++b) {
                weighted += row[b] * double{hit.weight[b]};
                all += row[b];
            }
            for (const Deposit& d : deposits) {
                if (d.patch != hit.patch) continue;
                double factor = share / kRays;
                // From 0.5 s on a quarter of the rays represents all.
                if (d.bin >= late_bin) factor *= has_late ? 4 : 0;
                const double shift_s = double{hit.length_m} / double{kSpeed_m_s};
                const double begin_s = bins.begin_s(d.bin) + shift_s;
                const double end_s = bins.end_s(d.bin) + shift_s;
                for (std::size_t k = 0; k < bins.count(); ++k) {
                    const double part = std::max(0.0, std::min(end_s, bins.end_s(k)) -
                                                          std::max(begin_s, bins.begin_s(k))) /
                                        (end_s - begin_s);
                    double sum = 0;
                    for (std::size_t b = 0; b < kBandCount; ++b) {
                        const double e = factor * part * double{d.energy()[b]};
                        energy[k][b] += e * double{hit.weight[b]};
                        sum += e * (cache.directed() ? weighted / all : double{hit.weight[b]});
                    }
                    add_weighted(sum,
                                 cache.directed() ? DirectionMoments::of(batch.departures[d.ray])
                                                  : hit.directions,
                                 directions[k]);
                }
            }
        }
        EnergyResponse response = silent();
        for (std::size_t k = 0; k < bins.count(); ++k) {
            double sum = 0;
            for (std::size_t b = 0; b < kBandCount; ++b) {
                response.energy[k][b] = static_cast<float>(energy[k][b]);
                sum += energy[k][b];
            }
            // The direction is no longer than the energy.
            const glm::dvec3 intensity(directions[k][0], directions[k][1], directions[k][2]);
            const double length = glm::length(intensity);
            std::array<float, 8> moments{};
            for (std::size_t i = 0; i < moments.size(); ++i)
                moments[i] =
                    static_cast<float>(directions[k][i] * (length > sum ? sum / length : 1.0));
            response.directions[k] = std::bit_cast<DirectionMoments>(moments);
        }
        return response;
    }

    EnergyResponse silent() const { return EnergyResponse::silent(bins, kSpeed_m_s); }
};

/// The largest difference of any energy or direction, over the largest energy of a bin.
double worst(const EnergyResponse& a, const EnergyResponse& b) {
    double max = 0;
    double difference = 0;
    for (std::size_t k = 0; k < a.bins.count(); ++k) {
        max = std::max(max, double{b.energy[k].sum()});
        for (std::size_t band = 0; band < kBandCount; ++band) {
            difference =
                std::max(difference, double{std::abs(a.energy[k][band] - b.energy[k][band])});
        }
        const Moments one = numbers(a.directions[k]);
        const Moments other = numbers(b.directions[k]);
        for (std::size_t i = 0; i < one.size(); ++i)
            difference = std::max(difference, std::abs(one[i] - other[i]));
    }
    return max > 0 ? difference / max : difference;
}

GatherHit hit_of(std::uint32_t patch, float length_m, bool late) {
    GatherHit hit;
    hit.patch = patch;
    hit.length_m = length_m;
    hit.directions = DirectionMoments::of(glm::normalize(Vec3(0.3F, -0.5F, 0.8F)));
    for (std::size_t b = 0; b < kBandCount; ++b) {
        hit.weight[b] = 0.1F * static_cast<float>(b + 1);
    }
    hit.late = late;
    return hit;
}

}  // namespace

TEST_CASE("radiated energy is delayed by the gather ray's length, uniform in time within its bin") {
    // Responses with bins of one, of four and of seven widths, and coarse ones.
    const TimeBins bins = GENERATE(TimeBins(0.06), TimeBins(0.4), TimeBins(2.5), TimeBins(0.9, 3));
    const bool directed = GENERATE(false, true);
    const bool late = GENERATE(false, true);
    const Rows rows(bins, 3, directed);
    // On borders of bins, between them, within the first bin, and beyond the end.
    for (const float length_m : {0.0F, 0.1F, 0.3432F, 5.0F, 17.16F, 40.4F, 200.0F}) {
        std::vector<GatherHit> hits;
        for (std::uint32_t patch = 0; patch < 3; ++patch) {
            hits.push_back(hit_of(patch, length_m * static_cast<float>(patch + 1), late));
        }
        EnergyResponse response = rows.silent();
        add_gathered(hits, rows.cache, response);
        CAPTURE(bins.length_s(), directed, late, length_m);
        // Rounding of times of up to 2.5 s to floats of a bin's width, and of some ten sums.
        const EnergyResponse expected = rows.expected(hits, 0.7);
        CHECK(worst(response, expected) < 2e-5);
        // Companion: a tenth of a millisecond is detected where possible.
        if (length_m < 10) {
            for (GatherHit& hit : hits) hit.length_m += 0.03432F;
            CHECK(worst(response, rows.expected(hits, 0.7)) > 2e-4);
        }
    }
}

TEST_CASE("the directions of consecutive hits have the spectra of their patches") {
    // More hits than chunks, so that a chunk has hits of several patches.
    Rows rows(TimeBins(0.06), 0, false);
    DepositBatch batch;
    batch.departures.resize(1, Vec3(1, 0, 0));
    for (std::uint32_t patch = 0; patch < 3; ++patch) {
        Deposit deposit;
        deposit.patch = patch;
        deposit.bin = 10;
        Bands energy;
        energy[3 * patch] = 1;  // 63 Hz, 500 Hz, 4 kHz
        deposit.set_energy(load_bands(energy), 0.5F);
        batch.deposits.add(deposit);
    }
    rows.batch = batch;
    rows.cache.clear();
    rows.fill_cache(3);
    std::vector<GatherHit> hits;
    for (std::uint32_t i = 0; i < 24; ++i)
        hits.push_back(hit_of(i / 8, 0.1F * static_cast<float>(i), false));
    EnergyResponse response = rows.silent();
    add_gathered(hits, rows.cache, response);
    // Rounding, as above.
    CHECK(worst(response, rows.expected(hits, 0.7)) < 2e-5);
}

TEST_CASE("gathers are the same to the bit for any order of their batches and parts") {
    Room room(0.4F, 1);
    const auto patches = static_cast<std::uint32_t>(room.grid.size());
    const Rows of_source(TimeBins(0.06), patches, false);
    const Rows of_listener(TimeBins(0.06), patches, true);
    GatherSettings settings;
    settings.rays = 1000;

    // Of both ends, which add to one response.
    const auto response_of = [&](const auto& run) {
        const Vec3 source = room.inside + Vec3(2, 1, 0);
        FinalGather at_listener(room.rays, room.grid, {.position = room.inside}, settings, 1);
        FinalGather at_source(room.rays, room.grid, {.position = source}, settings, 2);
        EnergyResponse response = of_source.silent();
        GatheredEnergy gathered(response, 8);
        gathered.add(at_listener.hits(), of_source.cache, 0.7);
        gathered.add(at_source.hits(), of_listener.cache, 0.3);
        for (FinalGather* gather : {&at_listener, &at_source})
            run(gather->batch_count(), [&](std::size_t batch) { gather->trace(batch); });
        run(gathered.part_count(), [&](std::size_t part) { gathered.sum(part); });
        return response;
    };
    const EnergyResponse in_order = response_of([](std::size_t count, const auto& job) {
        for (std::size_t i = 0; i < count; ++i) job(i);
    });
    const EnergyResponse reversed = response_of([](std::size_t count, const auto& job) {
        for (std::size_t i = count; i-- > 0;) job(i);
    });
    const EnergyResponse on_threads =
        response_of([&](std::size_t count, const auto& job) { room.workers.run(count, job); });
    CHECK_FALSE(in_order.energy == of_source.silent().energy);  // companion
    for (const EnergyResponse* other : {&reversed, &on_threads}) {
        CHECK(in_order.energy == other->energy);
        CHECK(in_order.directions == other->directions);
    }
}

TEST_CASE("air attenuates the whole length of a gather ray, including reflections at mirrors") {
    const Room room(0.4F);
    GatherSettings settings;
    settings.rays = 512;
    // The first band, without air, determines the roulette, so that bands can be compared ray by
    // ray.
    settings.attenuation_per_m[7] = 0.1F;
    settings.attenuation_per_m[6] = 0.03F;
    settings.mirrors = GENERATE(false, true);
    FinalGather gather(room.rays, room.grid, {.position = room.inside}, settings, 1);
    trace_all(gather);
    const std::vector<GatherHit>& hits = gather.hits();
    float longest_m = 0;
    for (const GatherHit& hit : hits) {
        longest_m = std::max(longest_m, hit.length_m);
        for (const std::size_t b : {6U, 7U}) {
            const double exact =
                std::exp(-double{settings.attenuation_per_m[b]} * double{hit.length_m});
            // Hits whose lengths differ by up to half a patch are joined: +- 0.25 m, and the
            // rounding of a dozen reflections.
            CHECK(double{hit.weight[b] / hit.weight[0]} == Approx(exact).epsilon(0.1 * 0.26));
        }
    }
    CHECK(hits.size() > 100);
    CHECK(longest_m > (settings.mirrors ? 15.0F : 5.0F));
}

TEST_CASE("joined hits of a patch have the mean length and directions of their rays") {
    const Room room(1);
    const RayScene& rays = room.rays;
    const PatchGrid& grid = room.grid;
    GatherSettings settings;
    settings.rays = 4096;
    settings.mirrors = false;
    FinalGather gather(room.rays, room.grid, {.position = room.inside}, settings, 1);
    trace_all(gather);
    const std::vector<GatherHit>& hits = gather.hits();
    const std::vector<Ray> sent = gather.rays();
    CHECK(gather.segments() == sent.size());
    CHECK(hits.size() < sent.size() / 2);

    // Sums over all rays that hit a patch, with the weight 4 / (M A).
    struct Sum {
        double weight = 0;
        double length = 0;
        Moments directions{};
    };
    std::vector<Sum> joined(grid.size());
    std::vector<Sum> alone(grid.size());
    const auto add = [](Sum& sum, double weight, double length_m,
                        const DirectionMoments& directions) {
        sum.weight += weight;
        sum.length += weight * length_m;
        add_weighted(weight, directions, sum.directions);
    };
    for (const GatherHit& hit : hits)
        add(joined[hit.patch], double{hit.weight[0]}, double{hit.length_m}, hit.directions);
    for (const Ray& ray : sent) {
        Hit hit;
        rays.intersect({&ray, 1}, {&hit, 1});
        const Vec3 point = rays.point(hit, ray.direction);
        const Vec3 normal = rays.facing_normal(hit, ray.direction);
        const std::uint32_t patch = grid.find(point, normal);
        REQUIRE(patch != PatchGrid::kNone);
        const float weight = 4 / (static_cast<float>(settings.rays) * grid.area_m2(patch)) *
                             grid.relative_irradiance(patch, hit.triangle, point, normal);
        add(alone[patch], double{weight}, double{hit.distance_m},
            DirectionMoments::of(ray.direction));
    }
    for (std::size_t p = 0; p < grid.size(); ++p) {
        if (alone[p].weight == 0) continue;
        CAPTURE(p);
        // Rounding of running means in single precision.
        REQUIRE(joined[p].weight == Approx(alone[p].weight).epsilon(1e-5));
        REQUIRE(joined[p].length == Approx(alone[p].length).epsilon(1e-5));
        for (std::size_t i = 0; i < joined[p].directions.size(); ++i)
            REQUIRE(std::abs(joined[p].directions[i] - alone[p].directions[i]) <
                    1e-5 * alone[p].weight);
    }
}

TEST_CASE("A gather sends all its rays, and none of its paths is longer than allowed") {
    // Mirrors that absorb a little: paths reflect many times.
    const Vec3 receiver(1.2F, 1.1F, 1.5F);
    const Scene scene =
        test::grey_room(test::box(Vec3(5, 4, 3)), 0.02F, 0.01F, receiver, Vec3(3, 3, 1));
    const RayScene rays(scene);
    WorkerPool workers(1);
    const PatchGrid grid(rays, 0.5F, {&receiver, 1}, 1, workers);
    for (const int count : {1, 1000, 1024, 1030}) {
        GatherSettings settings;
        settings.rays = count;
        settings.max_length_m = 30;
        const std::vector<Ray> sent =
            FinalGather(rays, grid, {.position = receiver}, settings, 1).rays();
        CAPTURE(count);
        CHECK(std::count_if(sent.begin(), sent.end(), [&](const Ray& ray) {
                  return ray.origin == receiver && ray.max_m == 30;
              }) == count);
        // The segment after a reflection has what is left of the length.
        double longest_m = 0;
        for (const Ray& ray : sent)
            if (ray.origin != receiver) longest_m = std::max(longest_m, double{ray.max_m});
        CHECK(longest_m < 30);
        CHECK(longest_m > 20);
        // The mean free path is 2.55 m: at most so many segments, and as many more.
        CHECK(sent.size() < static_cast<std::size_t>(count) * 30);
        CHECK(sent.size() > static_cast<std::size_t>(count) * 5);
    }
}

TEST_CASE(
    "gather rays behind walls that transmit end with their energy, however long the response") {
    Scene scene = test::row_of_rooms(2, 0.1F, 0.1F);
    const std::vector<Vec3> inside{scene.sources[0].position_at(0), scene.listener.pose.position};
    const auto segments = [&](float max_length_m) {
        const RayScene rays(scene);
        WorkerPool workers(2);
        const PatchGrid grid(rays, 0.5F, inside, 1, workers);
        Emitter receiver;
        receiver.position = inside[1];
        FinalGather gather(rays, grid, receiver, {.rays = 512, .max_length_m = max_length_m}, 1);
        trace_all(gather);
        return gather.segments();
    };
    const std::uint64_t opaque = segments(2000);
    // In the gap nearly each hit adds a ray.
    test::add_partition(scene, 4.5F, 20);
    test::add_partition(scene, 5.5F, 20);
    CHECK(segments(2000) < 4 * opaque);
}
