#include "engine/cache/diffuse_path_cache.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <vector>

#include "tests/support/statistics.h"

using namespace aula;
using Readout = DiffusePathCache::Readout;

namespace {

constexpr int kRays = 1000;
constexpr std::size_t kPlenty = 1'000'000'000;

Arrival arrival(std::uint64_t path, float length_m, float energy) {
    return {PathIdentifier{path, path}, 0, length_m, Vec3(0, 1, 0), Bands::filled(energy), 0};
}

void add_to(const DiffusePathCache& cache, EnergyResponse& response) {
    cache.add_to(SpecularSound{}, response);
}

double read_energy(const DiffusePathCache& cache) {
    EnergyResponse response = EnergyResponse::silent(TimeBins(1));
    add_to(cache, response);
    return response.total(0);
}

/// Mean energy over frames of a path that is hit a Poisson number of times (mean m) a frame, over
/// its true energy; in blocks, so that the standard error includes the correlation within the
/// window.
test::Estimate mean_over_true(Readout readout, double m, int window, int blocks,
                              int frames_per_block) {
    std::mt19937_64 random(test::test_seed());
    std::poisson_distribution<int> hits(m);
    DiffusePathCache cache(readout, window, kPlenty);
    std::vector<double> means;
    for (int f = 0; f < 2 * window; ++f) {
        cache.add_frame(
            std::vector<Arrival>(static_cast<std::size_t>(hits(random)), arrival(1, 10, 1)), kRays);
    }
    for (int block = 0; block < blocks; ++block) {
        double sum = 0;
        for (int f = 0; f < frames_per_block; ++f) {
            cache.add_frame(
                std::vector<Arrival>(static_cast<std::size_t>(hits(random)), arrival(1, 10, 1)),
                kRays);
            sum += read_energy(cache);
        }
        means.push_back(sum / frames_per_block / (m / kRays));
    }
    return test::estimate(means);
}

/// Mean over true energy of Eq. 3.2 as printed:
/// [sum over k = 1..F of (m / (1 - e^-m) + (k - 1) m) / k] / ((w + F) m), w = e^-m / (1 - e^-m).
double published_bias(double m, int window) {
    const double hit = 1 - std::exp(-m);
    double sum = 0;
    for (int k = 1; k <= window; ++k) sum += (m / hit + (k - 1) * m) / k;
    return sum / ((std::exp(-m) / hit + window) * m);
}

}  // namespace

TEST_CASE("the published bias formula tends to the harmonic number for rare paths") {
    double harmonic = 0;
    for (int k = 1; k <= 30; ++k) harmonic += 1.0 / k;
    CHECK(published_bias(1e-6, 30) == Approx(harmonic).epsilon(1e-4));  // O(m)
    CHECK(published_bias(1, 30) == Approx(1.057).margin(0.001));
    CHECK(published_bias(0.1, 30) == Approx(1.721).margin(0.001));
    CHECK(published_bias(0.01, 30) == Approx(3.30).margin(0.01));
}

TEST_CASE("dpc-published has the bias of the formula, dpc has none") {
    const double m = GENERATE(1.0, 0.1, 0.01);
    CAPTURE(m);
    const int per_block = m < 0.05 ? 4000 : 1000;
    const auto published = mean_over_true(Readout::published, m, 30, 40, per_block);
    CAPTURE(published.mean, published.standard_error);
    CHECK(std::abs(published.z(published_bias(m, 30))) < 3);
    CHECK(published.z(1.0) > test::kRefutedZ);  // companion: it is biased
    const auto windowed = mean_over_true(Readout::windowed, m, 30, 40, per_block);
    CAPTURE(windowed.mean, windowed.standard_error);
    CHECK(std::abs(windowed.z(1.0)) < 3);
    if (m < 0.5) CHECK(std::abs(windowed.z(published_bias(m, 30))) > test::kRefutedZ);
}

TEST_CASE("a published entry lives F frames including its first for any number of hits") {
    DiffusePathCache cache(Readout::published, 3, kPlenty);
    const std::vector<Arrival> hit{arrival(1, 10, 1)};
    cache.add_frame(hit, kRays);
    CHECK(read_energy(cache) == Approx(1.0 / kRays));
    cache.add_frame(hit, kRays);
    cache.add_frame({}, kRays);
    CHECK(read_energy(cache) == Approx(2.0 / (3 * kRays)));
    cache.add_frame({}, kRays);
    CHECK(cache.size() == 0);
}

TEST_CASE("an entry keeps the sums of Eq. 3.4 and reads out Eq. 3.2 and 3.3") {
    DiffusePathCache cache(Readout::published, 10, kPlenty);
    cache.add_frame(std::vector{arrival(7, 10, 1), arrival(7, 12, 0.5F), arrival(8, 20, 2)}, kRays);
    const DiffusePathCache::Entry* entry = cache.find({7, 7});
    REQUIRE(entry);
    CHECK(entry->arrival_count == 2);
    CHECK(entry->emitted_count == kRays);
    CHECK(entry->energy_sum[3] == DiffusePathCache::to_fixed(1) + DiffusePathCache::to_fixed(0.5F));
    EnergyResponse response = EnergyResponse::silent(TimeBins(1));
    add_to(cache, response);
    const std::size_t bin = response.bins.index(11.0 / double{response.speed_of_sound_m_s});
    CHECK(response.energy[bin][0] == Approx(1.5 / kRays));
    CHECK(response.directions[bin].intensity.y == Approx(8 * 1.5 / kRays));
    CHECK(response.directions[bin].yy == Approx(8 * 1.5 / kRays * 2 / 3));
    CHECK(response.total(0) == Approx(3.5 / kRays));
}

TEST_CASE("the window removes exactly the frames that have left it") {
    DiffusePathCache cache(Readout::windowed, 5, kPlenty);
    std::mt19937_64 random(4);
    std::uniform_real_distribution<float> energy(0, 1e-3F);
    std::uniform_int_distribution<std::uint64_t> path(0, 50);
    for (int f = 0; f < 100; ++f) {
        std::vector<Arrival> arrivals;
        for (int i = 0; i < 20; ++i) arrivals.push_back(arrival(path(random), 5, energy(random)));
        cache.add_frame(arrivals, kRays);
    }
    for (int f = 0; f < 4; ++f) cache.add_frame({}, kRays);
    CHECK(cache.size() > 0);
    // Fixed point leaves no remainder: entries are removed with their last arrival.
    cache.add_frame({}, kRays);
    CHECK(cache.size() == 0);
    CHECK(read_energy(cache) == 0);
}

TEST_CASE("entries that exceed the memory are removed, oldest first") {
    const auto readout = GENERATE(Readout::published, Readout::windowed);
    constexpr std::size_t kBytes = 100'000;
    DiffusePathCache cache(readout, 1000, kBytes);
    std::uint64_t path = 0;
    std::size_t max_frame_bytes = 0;
    for (int f = 0; f < 200; ++f) {
        std::vector<Arrival> arrivals;
        for (int i = 0; i < 50; ++i) arrivals.push_back(arrival(++path, 5, 1));
        cache.add_frame(arrivals, kRays);
        max_frame_bytes = std::max(max_frame_bytes, cache.memory_bytes());
    }
    // The bound holds before a frame's own arrivals: 50 entries of less than 1 kB.
    CHECK(max_frame_bytes < kBytes + 50'000);
    CHECK(cache.find({path, path}));
    CHECK_FALSE(cache.find({1, 1}));
    // The energy of the remaining entries is right: 50 arrivals of energy 1 in each frame.
    if (readout == Readout::windowed) CHECK(read_energy(cache) == Approx(50.0 / kRays));
}

TEST_CASE("the direction of a path is removed with its arrivals") {
    constexpr int kWindow = 3;
    DiffusePathCache cache(Readout::windowed, kWindow, kPlenty);
    const std::vector<Arrival> from_y(5, arrival(1, 10, 1));
    cache.add_frame(from_y, kRays);
    Arrival from_x = arrival(1, 10, 1);
    from_x.direction = Vec3(1, 0, 0);
    const auto direction = [&] {
        EnergyResponse response = EnergyResponse::silent(TimeBins(1));
        add_to(cache, response);
        Vec3 sum(0);
        for (const DirectionMoments& d : response.directions) sum += d.intensity;
        return sum;
    };
    for (int frame = 1; frame <= kWindow; ++frame) {
        CHECK(direction().y > 0);
        cache.add_frame(std::vector<Arrival>{from_x}, kRays);
    }
    CHECK(direction().y == 0);  // exact: fixed point
    CHECK(direction().x == Approx(kBandCount * 1.0 / kRays));
}
