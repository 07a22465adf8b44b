#include "engine/trace/resampling.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>

#include "engine/base/sampling.h"
#include "tests/support/statistics.h"

using namespace aula;

namespace {

/// Energies of `count` paths, grey or with different spectra.
std::vector<Bands> paths(std::size_t count, bool grey, float scale = 1) {
    std::vector<Bands> energies;
    RandomStream random(7);
    for (std::size_t i = 0; i < count; ++i) {
        Bands e = Bands::filled(scale * random.uniform());
        if (!grey) {
            for (float& x : e.value) x = scale * random.uniform() * random.uniform();
        }
        energies.push_back(e);
    }
    return energies;
}

}  // namespace

TEST_CASE("few paths all survive unchanged") {
    Resampler resampler;
    const std::vector<Bands> energies = paths(10, false);
    const auto survivors = resampler.choose(energies, std::vector<std::uint32_t>(10, 1), 10, 1);
    REQUIRE(survivors.size() == 10);
    for (std::size_t i = 0; i < 10; ++i) {
        CHECK(survivors[i].index == i);
        CHECK(survivors[i].factor == 1);
    }
}

TEST_CASE("resampling keeps the mean energy of every path in every band") {
    constexpr std::size_t kPaths = 60;
    constexpr int kRuns = 4000;
    std::vector<Bands> energies = paths(kPaths, false);
    std::vector<std::uint32_t> walls(kPaths, 1);
    // Three generations; the third is weak, and one of its bands is empty.
    for (std::size_t i = 20; i < kPaths; ++i) {
        walls[i] = i < 40 ? 2 : 3 + static_cast<std::uint32_t>(i % 2);
        if (i >= 40) {
            energies[i] *= 1e-6F;
            energies[i][3] = 0;
        }
    }
    Resampler resampler;
    std::vector<std::vector<double>> factor(kPaths, std::vector<double>(kRuns, 0));
    for (int run = 0; run < kRuns; ++run) {
        const auto survivors =
            resampler.choose(energies, walls, 24, derive_seed(test::test_seed(), run));
        CHECK(survivors.size() <= 24);
        for (const Resampler::Survivor& s : survivors) {
            factor[s.index][static_cast<std::size_t>(run)] += double{s.factor};
        }
    }
    for (std::size_t i = 0; i < kPaths; ++i) {
        const test::Estimate e = test::estimate(factor[i]);
        CAPTURE(i, e.mean, e.standard_error);
        // Rounding where a path is chosen in every run.
        CHECK(std::abs(e.mean - 1) < test::kFamilyZ * e.standard_error + 1e-5);
    }
    // Companion: a tenth less would be found in the sum over paths.
    std::vector<double> sum(kRuns, 0);
    for (std::size_t i = 0; i < kPaths; ++i) {
        for (std::size_t run = 0; run < kRuns; ++run) sum[run] += factor[i][run] / kPaths;
    }
    CHECK(std::abs(test::estimate(sum).z(0.9)) > test::kRefutedZ);
}

TEST_CASE("the energy of paths with equal spectra is unchanged, in each generation") {
    std::vector<Bands> energies = paths(100, true);
    std::vector<std::uint32_t> walls(100, 1);
    for (std::size_t i = 60; i < 100; ++i) {
        walls[i] = 2;
        energies[i] *= 1e-5F;
    }
    Resampler resampler;
    double before[2] = {0, 0};
    double after[2] = {0, 0};
    for (std::size_t i = 0; i < 100; ++i) before[walls[i] - 1] += double{energies[i][0]};
    for (const Resampler::Survivor& s : resampler.choose(energies, walls, 32, 5)) {
        after[walls[s.index] - 1] += double{s.factor} * double{energies[s.index][0]};
    }
    for (const int g : {0, 1}) {
        CHECK(after[g] == Approx(before[g]).epsilon(1e-5));  // rounding of 32 factors
    }
}

TEST_CASE("no place stays empty but the fraction of one in each generation") {
    const std::vector<Bands> energies = paths(100, true);
    std::vector<std::uint32_t> walls(100, 1);
    Resampler resampler;
    CHECK(resampler.choose(energies, walls, 30, 3).size() == 30);
    for (std::size_t i = 50; i < 100; ++i) walls[i] = i < 80 ? 2 : 3;
    // Systematic resampling chooses as many paths as there are places, to one by rounding.
    const std::size_t survivors = resampler.choose(energies, walls, 30, 3).size();
    CHECK(survivors >= 27);
    CHECK(survivors <= 30);
}

TEST_CASE("no generation and no band starves") {
    // The only path of its band is any path of the first generation.
    for (const std::size_t only : {0U, 4U, 89U}) {
        std::vector<Bands> energies = paths(100, true);
        std::vector<std::uint32_t> walls(100, 1);
        for (std::size_t i = 90; i < 100; ++i) {
            walls[i] = 2;
            energies[i] *= 1e-9F;
        }
        for (std::size_t i = 0; i < 90; ++i) energies[i][7] = 0;
        energies[only] = {};
        energies[only][7] = 1e-6F;
        Resampler resampler;
        int weak = 0;
        bool rare = false;
        for (const Resampler::Survivor& s : resampler.choose(energies, walls, 30, 3)) {
            weak += walls[s.index] == 2 ? 1 : 0;
            rare = rare || s.index == only;
        }
        CAPTURE(only);
        CHECK(weak == 5);
        CHECK(rare);
    }
}

TEST_CASE("a generation has places for its share of each band, however weak the band is") {
    // One generation has all energy of a strong band, the other one all energy of a weak band.
    std::vector<Bands> energies(100);
    std::vector<std::uint32_t> walls(100, 1);
    for (std::size_t i = 0; i < 50; ++i) energies[i][0] = 1;
    for (std::size_t i = 50; i < 100; ++i) {
        walls[i] = 2;
        energies[i][7] = 1e-6F;
    }
    Resampler resampler;
    int of_weak_band = 0;
    const auto survivors = resampler.choose(energies, walls, 30, 3);
    for (const Resampler::Survivor& s : survivors) of_weak_band += walls[s.index] == 2 ? 1 : 0;
    CHECK(survivors.size() == 30);
    CHECK(of_weak_band == 15);
}

TEST_CASE("thinning keeps the mean energy, and paths that never end by themselves die out") {
    constexpr int kRuns = 2000;
    constexpr int kSteps = 200;
    constexpr int kMiddle = 130;  // -59 dB: where all paths together may end
    double places = 0;
    double energy = 0;
    double square = 0;
    int alive = 0;
    RandomStream random(test::test_seed());
    for (int run = 0; run < kRuns; ++run) {
        Thinning thinning;
        double factor = 1;
        for (int step = 0; step < kSteps && factor > 0; ++step) {
            factor *= double{thinning.next(factor * std::pow(0.9, step), double{random.uniform()})};
            if (factor > 0) places += static_cast<double>(thinning.places());
            if (step != kMiddle) continue;
            energy += factor / kRuns;
            square += factor * factor / kRuns;
        }
        alive += factor > 0 ? 1 : 0;
    }
    // Four standard errors.
    CHECK(energy == Approx(1).margin(4 * std::sqrt((square - 1) / kRuns)));
    CHECK(square > 1.1);
    // Without thinning all paths live, in 32 places.
    CHECK(alive < kRuns / 10);
    CHECK(places / kRuns < 0.5 * 32 * kSteps);
}

TEST_CASE("Thinning is unchanged by steps without energy") {
    Thinning thinning;
    CHECK(thinning.next(0, 0.5) == 0);
    CHECK(thinning.places() == Thinning::kMost);
    CHECK(thinning.next(1, 0.5) == 1);
    CHECK(thinning.next(0, 0.5) == 0);
    // The roulette still counts all steps so far.
    CHECK(thinning.next(1e-12, 0.999) == 0);
}
