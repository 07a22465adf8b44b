#include "aula/engine/time_bins.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

using aula::TimeBins;

TEST_CASE("bins are contiguous from 0 to at least the length") {
    for (const double length_s : {0.0005, 0.001, 0.064, 0.5, 1.0, 2.0, 4.0, 10.0}) {
        for (const int coarseness : {1, 2, 3, 7}) {
            const TimeBins bins(length_s, coarseness);
            REQUIRE(bins.count() > 0);
            CHECK(bins.begin_s(0) == 0);
            for (std::size_t i = 1; i < bins.count(); ++i) {
                CHECK(bins.begin_s(i) == bins.end_s(i - 1));
            }
            CHECK(bins.end_s(bins.count() - 1) == bins.length_s());
            CHECK(bins.length_s() >= length_s);
            CHECK(bins.begin_s(bins.count() - 1) < length_s);  // no superfluous bin
        }
    }
}

TEST_CASE("bins are as wide as documented, times the coarseness") {
    const TimeBins bins(10.0);
    const auto width_ms = [&](double time_s) {
        const std::size_t i = bins.index(time_s);
        return (bins.end_s(i) - bins.begin_s(i)) * 1000;
    };
    // Approx: the difference of two rounded edges.
    CHECK(width_ms(0) == Approx(1));
    CHECK(width_ms(0.0635) == Approx(1));
    CHECK(width_ms(0.0645) == Approx(2));
    CHECK(width_ms(0.1285) == Approx(4));
    CHECK(width_ms(0.2565) == Approx(8));
    CHECK(width_ms(1.0235) == Approx(8));
    CHECK(width_ms(1.0245) == Approx(16));
    CHECK(width_ms(2.0485) == Approx(32));
    CHECK(width_ms(4.0965) == Approx(64));
    const TimeBins coarse(1.0, 3);
    CHECK(coarse.end_s(0) == Approx(0.003));
    CHECK(coarse.end_s(coarse.index(0.067)) - coarse.begin_s(coarse.index(0.067)) == Approx(0.006));
}

TEST_CASE("the index agrees with the edges to the last bit") {
    for (const int coarseness : {1, 3}) {
        const TimeBins bins(10.0, coarseness);
        for (std::size_t i = 0; i < bins.count(); ++i) {
            CHECK(bins.index(bins.begin_s(i)) == i);
            CHECK(bins.index(0.5 * (bins.begin_s(i) + bins.end_s(i))) == i);
            CHECK(bins.index(std::nextafter(bins.end_s(i), 0.0)) == i);
        }
    }
}

TEST_CASE("times at the end and beyond have no bin") {
    const TimeBins bins(1.0);
    CHECK(bins.index(bins.length_s()) == bins.count());
    CHECK(bins.index(1e30) == bins.count());
    CHECK(bins.index(std::numeric_limits<double>::infinity()) == bins.count());
    CHECK(bins.index(std::numeric_limits<double>::quiet_NaN()) == bins.count());
    CHECK(TimeBins().count() == 0);
    CHECK(TimeBins().index(0) == 0);
}
