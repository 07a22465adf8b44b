#include "apps/documents/report/report_cells.h"

#include <catch2/catch.hpp>

using namespace aula;

TEST_CASE("The digits of a value follow its error") {
    CHECK(value_cell({1.2345, 0.04}, 2) == "<td>1.23<small>± 0.04</small></td>");
    CHECK(value_cell({1.2345, 0.4}, 2) == "<td>1.2<small>± 0.4</small></td>");
    CHECK(value_cell({1.2345, 0.001}, 2) == "<td>1.23<small>&lt; 0.01</small></td>");
    CHECK(value_cell({1.2345, {}}, 2) == "<td>1.23</td>");
    CHECK(value_cell({{}, {}}, 2) == "<td>-</td>");
}

TEST_CASE("A mean of fewer positions than all has their number") {
    CHECK(mean_cell({0.5, {}}, {2.0, {}}, 3, 2) == "<td>0.50<small>2 of 3</small></td>");
    CHECK(mean_cell({0.5, {}}, {3.0, {}}, 3, 2) == "<td>0.50</td>");
    CHECK(mean_cell({{}, {}}, {{}, {}}, 3, 2) == "<td>-</td>");
}
