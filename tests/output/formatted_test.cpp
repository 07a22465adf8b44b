#include "apps/output/formatted.h"

#include <catch2/catch.hpp>
#include <limits>

using namespace aula;

TEST_CASE("A number that rounds to zero has no sign") {
    CHECK(fixed_text(-0.04, 1) == "0.0");
    CHECK(fixed_text(-0.0, 0) == "0");
    CHECK(fixed_text(-0.004, 2, 8) == "    0.00");
    // Companions: other numbers keep theirs.
    CHECK(fixed_text(-0.06, 1) == "-0.1");
    CHECK(fixed_text(-10, 1, 6) == " -10.0");
    CHECK(fixed_text(0.04, 1) == "0.0");
    CHECK(fixed_text(-std::numeric_limits<double>::infinity(), 1) == "-inf");
}
