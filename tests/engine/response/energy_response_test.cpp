#include "aula/engine/energy_response.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

using aula::Bands;
using aula::DirectionMoments;
using aula::EnergyResponse;
using aula::kBandCount;
using aula::TimeBins;
using aula::Vec3;

namespace {

/// Bins with ascending energies, and two paths: one within the response, one after its end.
EnergyResponse example() {
    EnergyResponse r = EnergyResponse::silent(TimeBins(0.3), 340);
    for (std::size_t i = 0; i < r.bins.count(); ++i) {
        r.energy[i] = Bands::filled(static_cast<float>(i + 1));
    }
    r.paths.push_back({.length_m = 3.4F + 0.17F, .energy = Bands::filled(1000)});  // 10.5 ms
    r.paths.push_back({.length_m = 3400, .energy = Bands::filled(1e6F)});
    return r;
}

}  // namespace

TEST_CASE("the total includes bins and paths that arrive before the end") {
    const EnergyResponse r = example();
    const auto n = static_cast<double>(r.bins.count());
    // Exact: integers below 2^24.
    CHECK(r.total(0) == n * (n + 1) / 2 + 1000);
}

TEST_CASE("a path that arrives when the last bin ends is after the response") {
    EnergyResponse r = EnergyResponse::silent(TimeBins(0.256), 1000);
    REQUIRE(r.bins.length_s() == 0.256);
    r.paths.push_back({.length_m = 256, .energy = Bands::filled(1)});
    CHECK(r.total(0) == 0);
    r.paths[0].length_m = 255.99F;
    CHECK(r.total(0) == 1);
}

TEST_CASE("uniform bins preserve the energy for any width") {
    const EnergyResponse r = example();
    for (const double width_s : {0.0003, 0.001, 0.0017, 0.01, 1.0}) {
        double sum = 0;
        for (const Bands& e : r.uniform(width_s)) sum += double{e[3]};
        CHECK(sum == Approx(r.total(3)).epsilon(1e-5));  // float sums of some hundred terms
    }
}

TEST_CASE("uniform bins of the original width equal the original bins") {
    const EnergyResponse r = example();
    const std::vector<Bands> u = r.uniform(0.001);
    for (std::size_t i = 0; i < 64; ++i) {
        const float path = i == 10 ? 1000.0F : 0.0F;
        CHECK(u[i][0] == r.energy[i][0] + path);  // exact: no energy leaks
    }
    // A bin of 2 ms divides its energy between two milliseconds.
    CHECK(u[64][0] + u[65][0] == Approx(r.energy[64][0]).epsilon(1e-6));
}

TEST_CASE("uniform bins follow an exponential decay") {
    // Bins of 4 and 8 ms do not divide 10 ms.
    EnergyResponse r = EnergyResponse::silent(TimeBins(0.5), 343);
    const auto decay = [](std::size_t band, double begin_s, double end_s) {
        const double rate_hz = 5 * static_cast<double>(band);  // 0 to 152 dB a second
        return band == 0 ? end_s - begin_s
                         : (std::exp(-rate_hz * begin_s) - std::exp(-rate_hz * end_s)) / rate_hz;
    };
    for (std::size_t i = 0; i < r.bins.count(); ++i) {
        for (std::size_t b = 0; b < kBandCount; ++b) {
            r.energy[i][b] = static_cast<float>(decay(b, r.bins.begin_s(i), r.bins.end_s(i)));
        }
    }
    for (const double width_s : {0.001, 0.0037, 0.01}) {
        const std::vector<Bands> u = r.uniform(width_s);
        for (std::size_t k = 0; static_cast<double>(k + 2) * width_s < 0.5; ++k) {
            for (std::size_t b = 0; b < kBandCount; ++b) {
                CAPTURE(width_s, k, b);
                // A slope across bins of different widths is that between their centres. Bins of
                // constant energy per time would err by up to 15 %.
                CHECK(double{u[k][b]} == Approx(decay(b, static_cast<double>(k) * width_s,
                                                      static_cast<double>(k + 1) * width_s))
                                             .epsilon(0.003));
            }
        }
    }
}

TEST_CASE("uniform bins beside silence and beside a peak have a limited slope") {
    EnergyResponse r = EnergyResponse::silent(TimeBins(0.5), 343);
    const std::size_t i = r.bins.index(0.3);
    r.energy[i] = Bands::filled(1);
    const auto first = static_cast<std::size_t>(std::lround(r.bins.begin_s(i) * 1000));
    std::vector<Bands> u = r.uniform(0.001);
    for (std::size_t k = first; k < first + 8; ++k) CHECK(u[k][2] == Approx(1.0 / 8).epsilon(1e-6));
    r.energy[i - 1] = Bands::filled(1e6F);
    r.energy[i + 1] = Bands::filled(1e-6F);
    u = r.uniform(0.001);
    CHECK(double{u[first][2]} / double{u[first + 7][2]} == Approx(std::exp(7.0 / 8)).epsilon(1e-4));
}

TEST_CASE("an empty response has no energy and no bins") {
    CHECK(EnergyResponse{}.total(0) == 0);
    CHECK(EnergyResponse{}.uniform(0.001).empty());
}

TEST_CASE("an arrival is added to the bin of its time unless it is later than the last bin") {
    EnergyResponse r = EnergyResponse::silent(TimeBins(0.3), 340);
    const DirectionMoments left = DirectionMoments::of(Vec3(0, 1, 0)) * 16;
    r.add(34.17, Bands::filled(2), left);  // 100.5 ms, in a bin of 2 ms from 100 ms on
    r.add(340, Bands::filled(1), left);    // 1 s
    const std::size_t bin = r.bins.index(0.1);
    CHECK(r.energy[bin] == Bands::filled(2));
    CHECK(r.directions[bin] == left);
    CHECK(r.total(0) == 2);
    r.paths.push_back({.length_m = 3.4F, .energy = Bands::filled(1)});
    r.clear_bins();
    CHECK(r.directions[bin] == DirectionMoments{});
    CHECK(r.total(0) == 1);  // the path
}

TEST_CASE("the free field of a source of unit energy has the squared pressure 1 at 1 m") {
    const double fluence_1_m2 = 1 / (4 * std::numbers::pi);
    CHECK(aula::squared_pressure(fluence_1_m2) == Approx(1));
    CHECK(aula::squared_pressure(fluence_1_m2 / 4) == Approx(0.25));  // 2 m
}
