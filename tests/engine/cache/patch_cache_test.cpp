#include "engine/cache/patch_cache.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <random>
#include <span>
#include <vector>

#include "engine/base/worker_pool.h"
#include "tests/support/statistics.h"

using namespace aula;

namespace {

constexpr std::size_t kBins = 10;
constexpr std::size_t kPatches = 20;
Deposit deposit_on(std::uint32_t patch, float energy) {
    Deposit deposit;
    deposit.patch = patch;
    deposit.bin = 3;
    deposit.set_energy(load_bands(Bands::filled(energy)), 0);
    return deposit;
}

/// Radiated energy of a patch in bin 3, band 0.
double radiated(const PatchCache& cache, std::uint32_t patch) {
    const PatchCache::Row& row = cache.row(patch);
    if (!row.sum) return 0;
    return double{row.sum[3 * kBandCount]} / static_cast<double>(cache.emitted());
}

/// Adds the deposits of rays on several threads.
void add(PatchCache& cache, int rays, std::span<const DepositBatch> batches, int threads = 2) {
    WorkerPool workers(threads);
    cache.begin_add(rays, kPatches);
    workers.run(DepositParts::kCount, [&](std::size_t part) { cache.add_part(batches, part); });
}

}  // namespace

TEST_CASE("a patch cache is the mean of the rays of all frames, and holds nothing once cleared") {
    PatchCache cache(kBins);
    const auto frame = [&](std::uint32_t patch, int rays) {
        DepositBatch batch;
        for (int ray = 0; ray < rays; ++ray) batch.deposits.add(deposit_on(patch, 1));
        add(cache, rays, {&batch, 1});
    };
    for (int f = 0; f < 100; ++f) frame(f % 2 ? 1 : 2, f % 2 ? 1 : 3);
    CHECK(cache.emitted() == 200);
    CHECK(cache.allocated_rows() == 2);
    CHECK(radiated(cache, 1) == Approx(0.25));
    CHECK(radiated(cache, 2) == Approx(0.75));
    cache.clear();
    CHECK(cache.emitted() == 0);
    CHECK(cache.allocated_rows() == 0);
    frame(2, 1);
    CHECK(radiated(cache, 1) == 0);
    CHECK(radiated(cache, 2) == Approx(1));
    CHECK(cache.emitted() == 1);
}

TEST_CASE("a patch cache is complete from 2^20 rays on") {
    PatchCache cache(kBins);
    const DepositBatch none;
    add(cache, (1 << 20) - 1, {&none, 1});
    CHECK_FALSE(cache.complete());
    add(cache, 1, {&none, 1});
    CHECK(cache.complete());
    cache.clear();
    CHECK_FALSE(cache.complete());
}

TEST_CASE("single precision holds the energy of 2^16 deposits in one bin") {
    // Energies over four decades, as of rays that have met few or many absorbing walls.
    std::mt19937_64 random(test::test_seed());
    std::uniform_real_distribution<float> uniform(0, 1);
    PatchCache cache(kBins);
    double sum = 0;
    for (int frame = 0; frame < 64; ++frame) {
        DepositBatch batch;
        for (int i = 0; i < 1024; ++i) {
            batch.deposits.add(deposit_on(1, std::pow(10.0F, -4 * uniform(random))));
            sum += double{batch.deposits.part[DepositParts::part_of(1)].back().energy()[0]};
        }
        add(cache, 1024, {&batch, 1});
    }
    // Deposits below 2^-24 of the sum are lost, at last those below 0.4 % of the mean.
    CHECK(radiated(cache, 1) == Approx(sum / (1 << 16)).epsilon(1e-4));
}

TEST_CASE("the sums of energy and direction are right, with the same bits for all threads") {
    // Reference by definition: the sums of the deposits' energies.
    std::mt19937_64 random(test::test_seed());
    std::uniform_real_distribution<float> uniform(0, 1);
    constexpr std::size_t kBatches = 7;
    constexpr std::size_t kRaysOfBatch = 20;
    std::vector<DepositBatch> batches(kBatches);
    std::vector<double> energy(kPatches * kBins * kBandCount, 0);
    std::vector<double> directions(kPatches * kBins * RowPool::kMoments, 0);
    for (DepositBatch& batch : batches) {
        for (std::size_t ray = 0; ray < kRaysOfBatch; ++ray) {
            batch.departures.push_back({uniform(random) - 0.5F, uniform(random) - 0.5F, 0.3F});
            for (int reflection = 0; reflection < 30; ++reflection) {
                Deposit deposit =
                    deposit_on(static_cast<std::uint32_t>(random() % kPatches), uniform(random));
                deposit.bin = static_cast<std::uint16_t>(random() % kBins);
                deposit.ray = static_cast<std::uint8_t>(ray);
                batch.deposits.add(deposit);
                const std::size_t at = deposit.patch * kBins + deposit.bin;
                for (std::size_t b = 0; b < kBandCount; ++b) {
                    energy[at * kBandCount + b] += double{deposit.energy()[b]};
                    const glm::dvec3 u(batch.departures[ray]);
                    const double third = glm::dot(u, u) / 3;
                    const std::array<double, RowPool::kMoments> moments{
                        u.x,       u.y,       u.z,      u.x * u.x - third, u.y * u.y - third,
                        u.x * u.y, u.y * u.z, u.z * u.x};
                    for (std::size_t i = 0; i < moments.size(); ++i)
                        directions[at * RowPool::kMoments + i] +=
                            double{deposit.energy()[b]} * moments[i];
                }
            }
        }
    }
    std::vector<float> bits;
    for (const int threads : {1, 2, 5}) {
        CAPTURE(threads);
        PatchCache cache(kBins, true);
        // In two frames.
        add(cache, 60, std::span(batches).first(3), threads);
        add(cache, 80, std::span(batches).subspan(3), threads);
        CHECK(cache.allocated_rows() == kPatches);
        std::vector<float> all;
        for (std::uint32_t p = 0; p < kPatches; ++p) {
            const PatchCache::Row& row = cache.row(p);
            REQUIRE(row.end_bin <= kBins);
            double total = 0;
            for (std::size_t bin = 0; bin < kBins; ++bin) {
                const std::size_t at = p * kBins + bin;
                for (std::size_t b = 0; b < kBandCount; ++b)
                    REQUIRE(double{row.sum[bin * kBandCount + b]} ==
                            Approx(energy[at * kBandCount + b]).epsilon(1e-6));
                for (std::size_t i = 0; i < RowPool::kMoments; ++i)
                    REQUIRE(
                        double{row.directions[bin * RowPool::kMoments + i]} ==
                        Approx(directions[at * RowPool::kMoments + i]).epsilon(1e-6).margin(1e-5));
                total += energy[at * kBandCount + 2];
            }
            CHECK(double{row.total[2]} == Approx(total).epsilon(1e-6));
            all.insert(all.end(), row.sum, row.sum + kBins * kBandCount);
            all.insert(all.end(), row.directions, row.directions + kBins * RowPool::kMoments);
        }
        if (bits.empty()) bits = all;
        CHECK(all == bits);
    }
}

TEST_CASE("a row is nonzero in its first and last bin only as long as it holds energy") {
    PatchCache cache(kBins);
    DepositBatch batch;
    for (const int bin : {6, 4, 8}) {
        Deposit deposit = deposit_on(5, 1);
        deposit.bin = static_cast<std::uint16_t>(bin);
        batch.deposits.add(deposit);
    }
    add(cache, 1, {&batch, 1});
    CHECK(cache.row_count() == kPatches);
    CHECK(cache.row(5).first_bin == 4);
    CHECK(cache.row(5).end_bin == 9);
    CHECK(cache.row(4).sum == nullptr);
    CHECK(cache.row(4).end_bin == 0);
}

TEST_CASE("the rows of an emptied cache are zero and serve another cache") {
    const auto memory = std::make_shared<RowPool>(kBins);
    const auto fill = [&](PatchCache& cache) {
        DepositBatch batch;
        batch.departures = {Vec3(1, 0, 0)};
        for (std::uint32_t p = 0; p < kPatches; ++p) batch.deposits.add(deposit_on(p, 1));
        add(cache, 1, {&batch, 1});
    };
    const std::size_t rows_bytes = kPatches * PatchCache::row_bytes(kBins, true);
    PatchCache first(kBins, true, memory);
    fill(first);
    CHECK(first.allocated_rows() == kPatches);
    CHECK(first.memory_bytes() >= rows_bytes);
    CHECK(memory->free_bytes() == 0);
    first.clear();
    CHECK(first.memory_bytes() < rows_bytes);
    CHECK(memory->free_bytes() == rows_bytes);
    {
        PatchCache second(kBins, true, memory);
        fill(second);
        CHECK(memory->free_bytes() == 0);
        for (std::uint32_t p = 0; p < kPatches; ++p) {
            const PatchCache::Row& row = second.row(p);
            for (std::size_t bin = 0; bin < kBins; ++bin) {
                CHECK((row.sum[bin * kBandCount] != 0) == (bin == 3));
                CHECK((row.directions[bin * RowPool::kMoments] != 0) == (bin == 3));
            }
        }
        CHECK(radiated(second, 7) == Approx(1));
    }
    // A cache that ends gives its rows back as well.
    CHECK(memory->free_bytes() == rows_bytes);
}

TEST_CASE("deposits preserve mean energies even if they are small relative to the strongest band") {
    Bands energy;
    for (std::size_t b = 0; b < kBandCount; ++b) {
        energy[b] = std::pow(10.0F, -static_cast<float>(b));
    }
    constexpr int kCount = 1 << 20;
    std::array<double, kBandCount> sum{};
    for (int i = 0; i < kCount; ++i) {
        Deposit deposit;
        deposit.set_energy(load_bands(energy), (static_cast<float>(i) + 0.5F) / kCount);
        for (std::size_t b = 0; b < kBandCount; ++b) sum[b] += double{deposit.energy()[b]} / kCount;
    }
    for (std::size_t b = 0; b < kBandCount; ++b) {
        // Unbiased rounding: right to one of 2^20 steps of a unit of 2^-14.
        CHECK(std::abs(sum[b] - double{energy[b]}) < 0x1p-34 + 1e-6 * double{energy[b]});
    }
    // Companion: truncation loses the smallest energy.
    Deposit deposit;
    deposit.set_energy(load_bands(energy), 0);
    CHECK(deposit.energy()[kBandCount - 1] == 0);
    CHECK_FALSE(deposit.empty());
}
