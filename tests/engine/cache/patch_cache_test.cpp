#include "engine/cache/patch_cache.h"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include "tests/support/statistics.h"

using namespace aula;

namespace {

constexpr std::size_t kBins = 10;
constexpr std::size_t kPatches = 20;
constexpr std::size_t kPlenty = 1'000'000'000;

Deposit deposit_on(std::uint32_t patch, float energy) {
    Deposit deposit;
    deposit.patch = patch;
    deposit.bin = 3;
    deposit.set_energy(load_bands(Bands::filled(energy)), 0);
    return deposit;
}

DepositBatch one_deposit(std::uint32_t patch, float energy) {
    DepositBatch batch;
    batch.segment_count = 1;
    batch.deposits.add(deposit_on(patch, energy));
    return batch;
}

/// Radiated energy of a patch in bin 3, band 0.
double radiated(const PatchCache& cache, std::uint32_t patch) {
    const PatchCache::Row& row = cache.row(patch);
    if (!row.sum) return 0;
    return static_cast<double>(row.sum[3 * kBandCount]) * PatchCache::kUnit /
           static_cast<double>(cache.emitted());
}

class Walk {
 public:
    explicit Walk(int window, std::size_t log_bytes = kPlenty)
        : cache(kBins, window, 0.5F, log_bytes), workers(1) {}

    void frame(const Vec3& source, std::uint32_t patch, double travel_m = 0) {
        DepositBatch batch = one_deposit(patch, 1);
        rest(source, travel_m);
        cache.add_frame(1, kPatches, {&batch, 1}, workers);
    }

    /// A frame in which no rays are sent.
    void rest(const Vec3& source, double travel_m = 0) {
        cache.advance({number++, source, travel_m}, true, workers);
    }

    std::uint64_t number = 0;

    PatchCache cache;
    WorkerPool workers;
};

}  // namespace

TEST_CASE("while nothing changes a patch cache accumulates without limit") {
    Walk walk(5);
    for (int f = 0; f < 100; ++f) walk.frame(Vec3(0), f % 2 ? 1 : 2);
    CHECK(walk.cache.emitted() == 100);
    CHECK(radiated(walk.cache, 1) == Approx(0.5));
    CHECK(radiated(walk.cache, 2) == Approx(0.5));
}

TEST_CASE("a cache is complete from 2^20 rays since the last change on") {
    Walk walk(5);
    const auto add = [&](int rays, const Vec3& source) {
        walk.rest(source);
        DepositBatch batch = one_deposit(1, 1);
        walk.cache.add_frame(rays, kPatches, {&batch, 1}, walk.workers);
        return walk.cache.complete();
    };
    CHECK_FALSE(add((1 << 20) - 1, Vec3(0)));
    CHECK(add(1, Vec3(0)));
    // Within the window; the rays from before the change do not count.
    CHECK_FALSE(add(1, Vec3(0.01F, 0, 0)));
}

TEST_CASE("after a movement of the source no energy older than the window remains") {
    Walk walk(5);
    for (int f = 0; f < 100; ++f) walk.frame(Vec3(0), 1);
    for (int f = 1; f <= 2; ++f) walk.frame(Vec3(0.01F, 0, 0), 2);
    CHECK(walk.cache.emitted() == 3);
    CHECK(radiated(walk.cache, 1) > 0);
    walk.frame(Vec3(0.01F, 0, 0), 2);
    CHECK(radiated(walk.cache, 1) == 0);
    CHECK(radiated(walk.cache, 2) == Approx(1));
    // The source is static again: energy accumulates again.
    for (int f = 0; f < 50; ++f) walk.frame(Vec3(0.01F, 0, 0), 2);
    CHECK(walk.cache.emitted() == 53);
}

TEST_CASE("a walking source keeps the frames within reach of the patch size") {
    Walk walk(30);
    for (int f = 0; f < 100; ++f) walk.frame(Vec3(0.05F * static_cast<float>(f), 0, 0), 1);
    // Valid within 0.15 of 0.5 m: the present frame and those up to 0.075 m behind.
    CHECK(walk.cache.emitted() == 2);
    Walk slow(30);
    for (int f = 0; f < 100; ++f) slow.frame(Vec3(0.02F * static_cast<float>(f), 0, 0), 1);
    CHECK(slow.cache.emitted() == 4);
}

TEST_CASE("after a jump only the present frame remains") {
    Walk walk(30);
    for (int f = 0; f < 20; ++f) walk.frame(Vec3(0), 1);
    walk.frame(Vec3(5, 0, 0), 2);
    CHECK(walk.cache.emitted() == 1);
    CHECK(radiated(walk.cache, 1) == 0);
}

TEST_CASE("a moving scene invalidates frames as a moving source does") {
    Walk walk(30);
    for (int f = 0; f < 20; ++f) walk.frame(Vec3(0), 1, 0.05 * f);
    CHECK(walk.cache.emitted() <= 5);
    for (int f = 0; f < 100; ++f) walk.frame(Vec3(0), 2, 0.05 * 20);
    CHECK(radiated(walk.cache, 1) == 0);
}

TEST_CASE("for any length of the log, sums and rays belong to the same frames") {
    // Steps, rests and jumps with frames of different size, each deposit of one ray.
    std::mt19937_64 random(test::test_seed());
    std::uniform_int_distribution<int> size(1, 40);
    std::uniform_int_distribution<int> length(1, 12);
    WorkerPool workers(1);
    int short_logs = 0;
    for (int trial = 0; trial < 300; ++trial) {
        // The table takes 14 kB of it; a frame of 20 deposits a kilobyte or two.
        const std::size_t memory = 14'000 + static_cast<std::size_t>(trial % 30) * 500;
        PatchCache cache(kBins, 8, 0.5F, memory);
        Vec3 source(0);
        std::uint64_t number = 0;
        for (int turn = 0; turn < 8; ++turn) {
            const float step_m = turn % 4 == 3 ? 5.0F : turn % 2 == 1 ? 0.02F : 0.0F;
            for (int f = length(random); f > 0; --f) {
                source.x += step_m;
                DepositBatch batch;
                const int rays = size(random);
                for (int i = 0; i < rays; ++i) {
                    batch.deposits.add(
                        deposit_on(static_cast<std::uint32_t>(i) % std::uint32_t{kPatches}, 1));
                }
                cache.advance({number++, source, 0}, true, workers);
                const std::uint64_t before = cache.emitted();
                cache.add_frame(rays, kPatches, {&batch, 1}, workers);
                REQUIRE(cache.emitted() >= static_cast<std::uint64_t>(rays));
                if (cache.emitted() < before + static_cast<std::uint64_t>(rays)) ++short_logs;
                double sum = 0;
                for (std::uint32_t p = 0; p < kPatches; ++p) sum += radiated(cache, p);
                REQUIRE(sum == Approx(1).epsilon(1e-9));
            }
        }
    }
    CHECK(short_logs > 100);  // frames were removed while others were added
}

TEST_CASE("removal is exact: the sums are those of the remaining frames") {
    std::mt19937_64 random(9);
    std::uniform_real_distribution<float> energy(0, 1);
    std::uniform_int_distribution<std::uint32_t> patch(0, kPatches - 1);
    WorkerPool workers(2);
    PatchCache moved(kBins, 4, 0.5F, kPlenty);
    PatchCache fresh(kBins, 4, 0.5F, kPlenty);
    for (int f = 0; f < 50; ++f) {
        std::vector<DepositBatch> batches;
        for (int i = 0; i < 100; ++i) batches.push_back(one_deposit(patch(random), energy(random)));
        const Vec3 source(0.05F * static_cast<float>(f), 0, 0);
        std::vector<DepositBatch> again = batches;
        const auto number = static_cast<std::uint64_t>(f);
        fresh.advance({number, source, 0}, true, workers);
        if (f >= 46) fresh.add_frame(100, kPatches, again, workers);
        moved.advance({number, source, 0}, true, workers);
        moved.add_frame(100, kPatches, batches, workers);
    }
    REQUIRE(moved.emitted() == fresh.emitted());
    for (std::uint32_t p = 0; p < kPatches; ++p) {
        const auto& a = moved.row(p).sum;
        const auto& b = fresh.row(p).sum;
        for (std::size_t i = 0; i < kBins * kBandCount; ++i) {
            CHECK((a ? a[i] : 0) == (b ? b[i] : 0));
        }
    }
}

TEST_CASE("a slowly moving source keeps exactly the frames of the window") {
    for (const int window : {1, 2, 5, 12}) {
        Walk walk(window);
        // Within 0.15 of the patch size all the time, so that only age decides.
        for (int f = 0; f < 40; ++f) {
            walk.frame(Vec3(1e-4F * static_cast<float>(f), 0, 0), 1);
            CHECK(walk.cache.emitted() == static_cast<std::uint64_t>(std::min(f + 1, window)));
        }
        // Frames without rays count for their age as well.
        walk.rest(Vec3(0.005F, 0, 0));
        CHECK(walk.cache.emitted() == static_cast<std::uint64_t>(window - 1));
    }
}

TEST_CASE("a source that starts moving slowly keeps a window of frames from the first step on") {
    constexpr int kWindow = 3;
    Walk walk(kWindow);
    for (int f = 0; f < 20; ++f) walk.frame(Vec3(0), 1);
    for (int f = 1; f <= 8; ++f) {
        walk.frame(Vec3(1e-4F * static_cast<float>(f), 0, 0), 2);
        CHECK(walk.cache.emitted() == kWindow);
        CHECK(radiated(walk.cache, 2) == Approx(std::min(1.0, f / double{kWindow})));
    }
}

TEST_CASE("a source that starts moving after a long rest keeps two frames and fills the window") {
    // The sums of the rest are rebuilt from logged frames: their number bounds the cost.
    constexpr int kWindow = 12;
    Walk walk(kWindow);
    for (int f = 0; f < 40; ++f) walk.frame(Vec3(0), 1);
    for (int f = 1; f <= 30; ++f) {
        walk.frame(Vec3(1e-4F * static_cast<float>(f), 0, 0), 2);
        // The frames of the rest expire by their age: the newest of them after kWindow frames.
        const int held = std::min(2 + f, kWindow);
        CHECK(walk.cache.emitted() == static_cast<std::uint64_t>(held));
        CHECK(radiated(walk.cache, 2) == Approx(std::min(1.0, f / static_cast<double>(held))));
    }
    // Companion: within the window all frames are logged, and none is lost.
    Walk brief(kWindow);
    for (int f = 0; f < kWindow - 1; ++f) brief.frame(Vec3(0), 1);
    brief.frame(Vec3(1e-4F, 0, 0), 2);
    CHECK(brief.cache.emitted() == kWindow);
}

TEST_CASE("the rows of an emptied cache are zero and serve another cache") {
    const auto memory = std::make_shared<RowPool>(kBins);
    WorkerPool workers(2);
    const auto fill = [&](PatchCache& cache, std::uint64_t number, const Vec3& source) {
        DepositBatch batch;
        batch.departures = {Vec3(1, 0, 0)};
        for (std::uint32_t p = 0; p < kPatches; ++p) batch.deposits.add(deposit_on(p, 1));
        cache.advance({number, source, 0}, true, workers);
        cache.add_frame(1, kPatches, {&batch, 1}, workers);
    };
    const std::size_t rows_bytes = kPatches * PatchCache::row_bytes(kBins, true);
    PatchCache first(kBins, 4, 0.5F, kPlenty, true, memory);
    fill(first, 0, Vec3(0));
    CHECK(first.allocated_rows() == kPatches);
    CHECK(memory->free_bytes() == 0);
    first.advance({1, Vec3(5, 0, 0), 0}, true, workers);  // a jump
    CHECK(first.emitted() == 0);
    CHECK(first.allocated_rows() == 0);
    CHECK(memory->free_bytes() == rows_bytes);
    {
        PatchCache second(kBins, 4, 0.5F, kPlenty, true, memory);
        fill(second, 0, Vec3(0));
        CHECK(memory->free_bytes() == 0);
        for (std::uint32_t p = 0; p < kPatches; ++p) {
            const PatchCache::Row& row = second.row(p);
            for (std::size_t bin = 0; bin < kBins; ++bin) {
                CHECK((row.sum[bin * kBandCount] != 0) == (bin == 3));
                CHECK((row.intensity[bin * 3] != 0) == (bin == 3));
            }
        }
        CHECK(radiated(second, 7) == Approx(1));
    }
    // A cache that ends gives its rows back as well.
    CHECK(memory->free_bytes() == rows_bytes);
}

TEST_CASE("frames that nobody wants are removed as soon as the emitter moves") {
    WorkerPool workers(2);
    for (const bool wanted : {true, false}) {
        CAPTURE(wanted);
        PatchCache cache(kBins, 30, 0.5F, kPlenty, false);
        const auto add = [&](std::uint64_t number, const Vec3& source) {
            cache.advance({number, source, 0}, wanted, workers);
            const std::uint64_t left = cache.emitted();
            DepositBatch batch;
            batch.departures = {Vec3(1, 0, 0)};
            batch.deposits.add(deposit_on(0, 1));
            cache.add_frame(1, kPatches, {&batch, 1}, workers);
            return left;
        };
        // At rest all frames are of use.
        for (std::uint64_t f = 0; f < 10; ++f) CHECK(add(f, Vec3(0)) == f);
        CHECK(add(10, Vec3(0.01F, 0, 0)) == (wanted ? 10 : 0));
        CHECK(cache.is_current() == !wanted);
        CHECK(add(11, Vec3(0.01F, 0, 0)) == (wanted ? 11 : 1));
    }
}

TEST_CASE("after a small step each new frame replaces one from before") {
    Walk walk(30);
    constexpr int kBefore = 10;
    for (int f = 0; f < kBefore; ++f) walk.frame(Vec3(0), 1);
    for (int f = 1; f <= 20; ++f) {
        walk.frame(Vec3(0.05F, 0, 0), 2);
        // As many as right after the step until all are newer than the step; then more.
        const int held = std::max(kBefore + 1, f);
        CHECK(walk.cache.emitted() == static_cast<std::uint64_t>(held));
        CHECK(radiated(walk.cache, 2) == Approx(f / static_cast<double>(held)));
    }
}

TEST_CASE("a listener's directions are those of the remaining frames, to the bit") {
    // Frames removed one by one, and most of them together.
    const bool static_first = GENERATE(false, true);
    CAPTURE(static_first);
    std::mt19937_64 random(10);
    std::uniform_real_distribution<float> uniform(0, 1);
    constexpr int kFrames = 30;
    constexpr int kWindow = 4;
    constexpr int kRaysOfFrame = 20;
    WorkerPool workers(2);
    PatchCache moved(kBins, kWindow, 0.5F, kPlenty, true);
    PatchCache fresh(kBins, kWindow, 0.5F, kPlenty, true);
    for (int f = 0; f < kFrames; ++f) {
        DepositBatch batch;
        for (int ray = 0; ray < kRaysOfFrame; ++ray) {
            batch.departures.push_back({uniform(random) - 0.5F, uniform(random) - 0.5F, 0.3F});
            Deposit deposit =
                deposit_on(static_cast<std::uint32_t>(random() % kPatches), uniform(random));
            deposit.ray = static_cast<std::uint8_t>(ray);
            batch.deposits.add(deposit);
        }
        DepositBatch again = batch;
        // Small steps, so that only the window decides; at the end or all the time.
        const int steps = static_first ? std::max(0, f - (kFrames - 3)) : f;
        const PatchCache::State state{static_cast<std::uint64_t>(f),
                                      Vec3(1e-4F * static_cast<float>(steps), 0, 0), 0};
        fresh.advance(state, true, workers);
        if (f >= kFrames - kWindow) fresh.add_frame(kRaysOfFrame, kPatches, {&again, 1}, workers);
        moved.advance(state, true, workers);
        moved.add_frame(kRaysOfFrame, kPatches, {&batch, 1}, workers);
    }
    REQUIRE(moved.emitted() == kWindow * kRaysOfFrame);
    REQUIRE(fresh.emitted() == moved.emitted());
    int held = 0;
    for (std::uint32_t p = 0; p < kPatches; ++p) {
        const PatchCache::Row& a = moved.row(p);
        const PatchCache::Row& b = fresh.row(p);
        const auto same = [](const std::int64_t* x, const std::int64_t* y, std::size_t count) {
            for (std::size_t i = 0; i < count; ++i) {
                if ((x ? x[i] : 0) != (y ? y[i] : 0)) return false;
            }
            return true;
        };
        CHECK(same(a.sum, b.sum, kBins * kBandCount));
        CHECK(same(a.intensity, b.intensity, kBins * 3));
        if (b.intensity && b.intensity[3 * 3] != 0) ++held;
    }
    CHECK(held > 10);
}

TEST_CASE("a short log bounds the memory") {
    Walk walk(1000, 20 * sizeof(Deposit));
    for (int f = 0; f < 100; ++f) walk.frame(Vec3(1e-4F * static_cast<float>(f), 0, 0), 1);
    CHECK(walk.cache.emitted() <= 21);
    CHECK(radiated(walk.cache, 1) == Approx(1));
}

TEST_CASE("rows and logged frames are within the memory of a cache but for one frame") {
    Walk two(1000);
    two.frame(Vec3(0), 1);
    const std::size_t of_one = two.cache.memory_bytes();
    two.frame(Vec3(0), 1);
    const std::size_t frame_bytes = two.cache.memory_bytes() - of_one;
    for (const std::size_t bytes : {4000U, 8000U, 16000U}) {
        Walk walk(1000, bytes);
        for (int f = 0; f < 100; ++f) {
            walk.frame(Vec3(1e-4F * static_cast<float>(f), 0, 0), 1);
            CAPTURE(bytes, f);
            CHECK(walk.cache.memory_bytes() <= bytes + frame_bytes);
        }
        // Companion: a good part of it is used.
        CHECK(walk.cache.memory_bytes() > bytes / 2);
    }
}

TEST_CASE("without new rays the log of a patch cache ages out, and sums and later changes do not") {
    Walk walk(5);
    for (int f = 0; f < 20; ++f) walk.frame(Vec3(0), f % 2 ? 1 : 2);
    const std::size_t before = walk.cache.memory_bytes();
    for (int f = 0; f < 5; ++f) walk.rest(Vec3(0));
    const std::size_t rested = walk.cache.memory_bytes();
    CHECK(rested + 5 * sizeof(Deposit) <= before);
    CHECK(walk.cache.emitted() == 20);
    CHECK(radiated(walk.cache, 1) == Approx(0.5));
    // A small step after three frames of rest keeps the two newest frames.
    Walk other(5);
    for (int f = 0; f < 20; ++f) other.frame(Vec3(0), f % 2 ? 1 : 2);
    for (int f = 0; f < 2; ++f) other.rest(Vec3(0));
    other.rest(Vec3(0.01F, 0, 0));
    CHECK(other.cache.emitted() == 2);
    CHECK(radiated(other.cache, 1) == Approx(0.5));
    // After a longer rest it keeps none.
    walk.rest(Vec3(0.01F, 0, 0));
    CHECK(walk.cache.emitted() == 0);
    walk.frame(Vec3(0.01F, 0, 0), 3);
    CHECK(radiated(walk.cache, 3) == Approx(1));
    CHECK(radiated(walk.cache, 1) == 0);
}

TEST_CASE("a frame that leaves the log gives its memory to the next frame, static or walking") {
    for (const float step_m : {0.0F, 0.01F}) {
        Walk walk(5);
        DepositBatch batch;
        for (int f = 0; f < 12; ++f) {
            // The tracer fills the batch that the last call returned.
            const std::size_t part = DepositParts::part_of(1);
            if (f > 7) CHECK(batch.deposits.part[part].capacity() > 0);
            batch.clear();
            batch.deposits.add(deposit_on(1, 1));
            walk.rest(Vec3(static_cast<float>(f) * step_m, 0, 0));
            walk.cache.add_frame(1, kPatches, {&batch, 1}, walk.workers);
        }
    }
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
        const BandSums units = deposit.units();
        for (std::size_t b = 0; b < kBandCount; ++b) {
            sum[b] += static_cast<double>(units[b]) * Deposit::kUnit / kCount;
        }
    }
    for (std::size_t b = 0; b < kBandCount; ++b) {
        // Unbiased rounding: right to one of 2^20 steps of a unit of 2^-14.
        CHECK(std::abs(sum[b] - double{energy[b]}) < 0x1p-34 + 1e-6 * double{energy[b]});
    }
    // Companion: truncation loses the smallest energy.
    Deposit deposit;
    deposit.set_energy(load_bands(energy), 0);
    CHECK(deposit.units()[kBandCount - 1] == 0);
    CHECK_FALSE(deposit.empty());
}
