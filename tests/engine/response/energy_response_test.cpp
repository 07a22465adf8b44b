#include "aula/engine/energy_response.h"

#include <catch2/catch.hpp>
#include <numbers>

using aula::Bands;
using aula::EnergyResponse;
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
    // A bin of 2 ms gives half of its energy to each millisecond.
    CHECK(u[64][0] == Approx(r.energy[64][0] / 2).epsilon(1e-6));
    CHECK(u[65][0] == Approx(r.energy[64][0] / 2).epsilon(1e-6));
}

TEST_CASE("an empty response has no energy and no bins") {
    CHECK(EnergyResponse{}.total(0) == 0);
    CHECK(EnergyResponse{}.uniform(0.001).empty());
}

TEST_CASE("an arrival is added to the bin of its time unless it is later than the last bin") {
    EnergyResponse r = EnergyResponse::silent(TimeBins(0.3), 340);
    r.add(34.17, Bands::filled(2), Vec3(0, 16, 0));  // 100.5 ms, in a bin of 2 ms from 100 ms on
    r.add(340, Bands::filled(1), Vec3(1, 0, 0));     // 1 s
    const std::size_t bin = r.bins.index(0.1);
    CHECK(r.energy[bin] == Bands::filled(2));
    CHECK(r.intensity[bin] == Vec3(0, 16, 0));
    CHECK(r.total(0) == 2);
    r.paths.push_back({.length_m = 3.4F, .energy = Bands::filled(1)});
    r.clear_bins();
    CHECK(r.intensity[bin] == Vec3(0));
    CHECK(r.total(0) == 1);  // the path
}

TEST_CASE("the free field of a source of unit energy has the squared pressure 1 at 1 m") {
    const double fluence_1_m2 = 1 / (4 * std::numbers::pi);
    CHECK(aula::squared_pressure(fluence_1_m2) == Approx(1));
    CHECK(aula::squared_pressure(fluence_1_m2 / 4) == Approx(0.25));  // 2 m
}
