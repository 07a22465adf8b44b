#include "aula/engine/energy_response.h"

#include <catch2/catch.hpp>

using aula::Bands;
using aula::EnergyResponse;
using aula::TimeBins;

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
