#include "engine/base/shifted_histogram.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>
#include <random>
#include <vector>

#include "tests/support/statistics.h"

using namespace aula;

namespace {

constexpr std::size_t kBand = 5;

/// A histogram that owns its numbers.
struct Histogram {
    std::vector<float> energy;
    std::vector<float> directions{};
    Bands total{};

    TimeHistogram view() const {
        return {energy.data(), directions.empty() ? nullptr : directions.data(), total};
    }
};

/// Random energies in bins [first_bin, end_bin), none elsewhere.
Histogram random_histogram(const TimeBins& bins, std::size_t first_bin, std::size_t end_bin) {
    Histogram histogram{std::vector<float>(bins.count() * kBandCount)};
    std::mt19937_64 random(test::test_seed());
    std::uniform_real_distribution<float> uniform(0, 1);
    for (std::size_t k = first_bin; k < end_bin; ++k) {
        for (std::size_t b = 0; b < kBandCount; ++b) {
            const float energy = uniform(random);
            histogram.energy[k * kBandCount + b] = energy;
            histogram.total[b] += energy;
        }
    }
    return histogram;
}

/// The histogram alone, delayed, with a weight of 1.
ShiftedHistogram shifted(const TimeBins& bins, const Histogram& histogram, double delay_s) {
    ShiftedHistogram sum(bins);
    sum.add(histogram.view(), 0, bins.count(), delay_s, Bands::filled(1), {});
    return sum;
}

/// Energy of a band and its mean time; a bin's energy is at its middle in the mean.
struct EnergyInTime {
    double energy = 0;
    double mean_s = 0;
};

template <typename EnergyOfBin>
EnergyInTime energy_in_time(const TimeBins& bins, const EnergyOfBin& energy) {
    EnergyInTime all;
    for (std::size_t k = 0; k < bins.count(); ++k) {
        all.energy += double{energy(k)};
        all.mean_s += double{energy(k)} * (bins.begin_s(k) + bins.end_s(k)) / 2;
    }
    all.mean_s /= all.energy;
    return all;
}

/// The energy of a band up to a time.
double energy_until(const TimeBins& bins, const Histogram& histogram, double time_s) {
    double energy = 0;
    for (std::size_t k = 0; k < bins.count(); ++k) {
        const double width_s = bins.end_s(k) - bins.begin_s(k);
        energy += double{histogram.energy[k * kBandCount + kBand]} *
                  std::clamp((time_s - bins.begin_s(k)) / width_s, 0.0, 1.0);
    }
    return energy;
}

/// The largest difference, at the end of any bin, of the energy up to then and that of the
/// histogram up to `delay_s` before; relative to the whole.
double worst_cumulative(const TimeBins& bins, const Histogram& histogram,
                        const ShiftedHistogram& later, double delay_s) {
    double energy = 0;
    double worst = 0;
    for (std::size_t k = 0; k < bins.count(); ++k) {
        energy += double{later.energy(k)[kBand]};
        worst = std::max(worst,
                         std::abs(energy - energy_until(bins, histogram, bins.end_s(k) - delay_s)));
    }
    return worst / double{histogram.total[kBand]};
}

}  // namespace

TEST_CASE("a delay between bins of one width keeps the energy and moves its mean time exactly") {
    const TimeBins bins(0.06);
    const Histogram histogram = random_histogram(bins, 3, 20);
    const EnergyInTime before = energy_in_time(
        bins, [&](std::size_t k) { return histogram.energy[k * kBandCount + kBand]; });
    for (const double delay_s : {0.0, 0.001, 0.0123, 1e-5, 0.03999, 0.00050001}) {
        const ShiftedHistogram later = shifted(bins, histogram, delay_s);
        const EnergyInTime after =
            energy_in_time(bins, [&](std::size_t k) { return later.energy(k)[kBand]; });
        CAPTURE(delay_s);
        // Single precision over some twenty bins; times are in seconds.
        CHECK(after.energy == Approx(before.energy).epsilon(1e-6));
        CHECK(after.mean_s - before.mean_s == Approx(delay_s).margin(1e-8));
    }
    // The companion: 10 us more are not the same.
    const ShiftedHistogram later = shifted(bins, histogram, 0.01231);
    const EnergyInTime after =
        energy_in_time(bins, [&](std::size_t k) { return later.energy(k)[kBand]; });
    CHECK(std::abs(after.mean_s - before.mean_s - 0.0123) > 9e-6);
}

TEST_CASE("the energy up to the end of each bin is that up to a delay before") {
    // Bins of one, of four and of seven widths, and coarse ones: from narrow bins into wider ones.
    const TimeBins bins = GENERATE(TimeBins(0.06), TimeBins(0.4), TimeBins(2.5), TimeBins(0.9, 3));
    const Histogram histogram = random_histogram(bins, 0, bins.count());
    for (const double delay_s : {0.0, 0.0003, 0.001, 0.0147, 0.05, 0.1183, 0.59}) {
        const ShiftedHistogram later = shifted(bins, histogram, delay_s);
        CAPTURE(bins.length_s(), delay_s);
        // Single precision: the energies, and the share of a bin that has been passed.
        CHECK(worst_cumulative(bins, histogram, later, delay_s) < 2e-6);
        // The companion: a tenth of a bin's width of 1 ms more, while energy arrives.
        if (delay_s < 0.05) {
            CHECK(worst_cumulative(bins, histogram, later, delay_s + 1e-4) > 2e-5);
        }
    }
}

TEST_CASE("energy after the last bin is lost, and only that") {
    const TimeBins bins(0.4);
    const Histogram histogram = random_histogram(bins, 0, bins.count());
    const ShiftedHistogram later = shifted(bins, histogram, 0.25);
    const EnergyInTime after =
        energy_in_time(bins, [&](std::size_t k) { return later.energy(k)[kBand]; });
    CHECK(after.energy ==
          Approx(energy_until(bins, histogram, bins.length_s() - 0.25)).epsilon(1e-6));
    CHECK(after.energy < 0.95 * double{histogram.total[kBand]});
    for (const double delay_s : {bins.length_s(), bins.length_s() + 0.3}) {
        const ShiftedHistogram none = shifted(bins, histogram, delay_s);
        for (std::size_t k = 0; k < bins.count(); ++k) REQUIRE(none.energy(k) == Bands{});
    }
}

TEST_CASE("directions are delayed as energies are") {
    const TimeBins bins(0.9);
    Histogram histogram = random_histogram(bins, 2, bins.count() - 30);
    const DirectionMoments direction = DirectionMoments::of(Vec3(0.6F, 0, -0.8F));
    Bands weight;
    for (std::size_t b = 0; b < kBandCount; ++b) weight[b] = 0.25F * static_cast<float>(b);
    ShiftedHistogram of_direction(bins);
    of_direction.add(histogram.view(), 0, bins.count(), 0.0313, weight, direction);
    for (std::size_t k = 0; k < bins.count(); ++k) {
        const auto energy = histogram.energy.begin() + static_cast<std::ptrdiff_t>(k * kBandCount);
        const auto& [u, xx, yy, xy, yz, zx] =
            direction * std::accumulate(energy, energy + kBandCount, 0.0F);
        histogram.directions.insert(histogram.directions.end(),
                                    {u.x, u.y, u.z, xx, yy, xy, yz, zx});
    }
    ShiftedHistogram of_directions(bins);
    of_directions.add(histogram.view(), 0, bins.count(), 0.0313, weight, {});
    double all = 0;
    double weighted = 0;
    for (std::size_t b = 0; b < kBandCount; ++b) {
        all += double{histogram.total[b]};
        weighted += double{weight[b]} * double{histogram.total[b]};
    }
    const ShiftedHistogram later = shifted(bins, histogram, 0.0313);
    for (std::size_t k = 0; k < bins.count(); ++k) {
        CAPTURE(k);
        // Given directions have the mean weight over the total, a given direction that of the bin.
        const auto check = [&](const DirectionMoments& moments, double energy) {
            const auto is = [&](double factor) {
                return Approx(factor * energy).epsilon(2e-6).margin(1e-9);
            };
            REQUIRE(double{moments.intensity.x} == is(0.6));
            REQUIRE(double{moments.intensity.y} == 0);
            REQUIRE(double{moments.intensity.z} == is(-0.8));
            REQUIRE(double{moments.xx} == is(0.36 - 1.0 / 3));
            REQUIRE(double{moments.yy} == is(-1.0 / 3));
            REQUIRE(double{moments.zx} == is(-0.48));
        };
        check(of_directions.directions(k), double{later.energy(k).sum()} * weighted / all);
        check(of_direction.directions(k), double{(weight * later.energy(k)).sum()});
        for (std::size_t b = 0; b < kBandCount; ++b) {
            REQUIRE(double{of_direction.energy(k)[b]} ==
                    Approx(double{weight[b] * later.energy(k)[b]}).epsilon(1e-6));
        }
    }
}
