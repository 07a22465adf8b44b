#include "apps/window/view/map_cells.h"

#include <catch2/catch.hpp>

using namespace aula;

namespace {

constexpr auto kC80 = static_cast<std::size_t>(AcousticParameter::c80);

/// Two receivers, 1 m apart, in a room of 2 x 1.2 m; the values are -2 and 4 dB, of the second
/// source 1 dB and none. The octave of 1 kHz has 10 dB more.
struct TwoCells {
    ReceiverGrid grid;
    Measurement measurement;
    Bounds bounds;

    TwoCells() {
        grid.height_m = 1;
        grid.spacing_m = 1;
        grid.receivers = {{.position = {0.5F, 0.6F, 1}}, {.position = {1.5F, 0.6F, 1}}};
        measurement.receivers = grid.receivers;
        measurement.sources.resize(2);
        measurement.parameters.resize(4);
        const std::optional<double> values[]{-2.0, 4.0, 1.0, std::nullopt};
        for (std::size_t pair = 0; pair < 4; ++pair) {
            measurement.parameters[pair].broadband[kC80].value = values[pair];
            if (values[pair])
                measurement.parameters[pair].octaves[kC80][4].value = *values[pair] + 10;
        }
        bounds.min = {0.2F, 0, 0};
        bounds.max = {2, 1.2F, 3};
    }

    MapCells cells(std::size_t source, std::optional<std::size_t> band = {}) const {
        return {grid, measurement, bounds, {.source = source, .parameter = kC80, .band = band}};
    }
};

}  // namespace

TEST_CASE("A map's cells have the values of their source and octave, in the colours of the scale") {
    const TwoCells room;
    const MapCells broadband = room.cells(0);
    REQUIRE(broadband.cells().size() == 2);
    CHECK(broadband.cells()[0].value == -2.0);
    CHECK(broadband.scale().min == Approx(-2));
    CHECK(broadband.scale().max == Approx(4));
    CHECK(broadband.colour(broadband.cells()[0]) == map_colour(0));
    CHECK(broadband.colour(broadband.cells()[1]) == map_colour(1));
    CHECK(room.cells(0, 4).cells()[1].value == 14.0);
    const MapCells second = room.cells(1);
    CHECK(second.cells()[0].value == 1.0);
    CHECK(second.colour(second.cells()[1]) == kNoValueColour);
}

TEST_CASE("A map's cells end at the bounds of the room, and are found by a point") {
    const TwoCells room;
    const MapCells map = room.cells(0);
    CHECK(map.cells()[0].low.x == 0.2F);
    CHECK(map.cells()[0].high.x == 1.0F);
    CHECK(map.at({0.3F, 0.5F}) == &map.cells()[0]);
    CHECK(map.at({1.2F, 0.5F}) == &map.cells()[1]);
    CHECK(map.at({0.1F, 0.5F}) == nullptr);
}
