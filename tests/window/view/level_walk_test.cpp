#include "apps/window/view/level_walk.h"

#include <catch2/catch.hpp>
#include <numbers>

using namespace aula;

namespace {

/// A frame with the listener at x, and direct sound of two paths and a reflection.
FrameView view_at(std::uint64_t frame, float x_m, float pressure) {
    FrameView view;
    view.frame = frame;
    view.listener.position = {x_m, 0, 0};
    SoundPath path;
    // The squared pressure of a fluence is 4 pi times as large.
    path.energy = Bands::filled(pressure * pressure / (8 * std::numbers::pi_v<float>));
    view.response.paths = {path, path, path};
    view.response.paths[1].key = 3;
    view.response.paths[2].order = 1;
    return view;
}

}  // namespace

TEST_CASE("The levels of a walk are those of all direct paths, over the way walked") {
    LevelWalk walk;
    CHECK(walk.points().empty());
    for (std::uint64_t i = 0; i <= 50; ++i)
        walk.add(view_at(i, 0.1F * static_cast<float>(i), i < 20 ? 1.0F : 0.1F));
    REQUIRE(walk.points().size() == 51);
    CHECK(walk.points().front().walked_m == 0);
    CHECK(walk.points().back().walked_m == Approx(5).epsilon(1e-4));
    for (std::size_t band = 0; band < kBandCount; ++band) {
        CHECK(walk.points()[19].level_db[band] == Approx(0).margin(1e-3));
        CHECK(walk.points()[20].level_db[band] == Approx(-20).margin(1e-3));
    }
    // The same frame again, and one at the same place.
    walk.add(view_at(50, 5, 1));
    CHECK(walk.points().back().level_db[0] == Approx(-20).margin(1e-3));
    walk.add(view_at(51, 5.001F, 1));
    CHECK(walk.points().size() == 51);
    CHECK(walk.points().back().level_db[0] == Approx(0).margin(1e-3));
}

TEST_CASE("A walk keeps its last metres, and a jump and another source begin a new one") {
    LevelWalk walk;
    for (std::uint64_t i = 0; i < 200; ++i) walk.add(view_at(i, 0.5F * static_cast<float>(i), 1));
    CHECK(walk.points().size() == 21);
    CHECK(walk.points().back().walked_m == Approx(99.5));
    walk.add(view_at(200, 0, 1));
    CHECK(walk.points().size() == 1);
    FrameView other = view_at(201, 0.5F, 1);
    walk.add(other);
    CHECK(walk.points().size() == 2);
    other.source = 1;
    other.frame = 202;
    walk.add(other);
    CHECK(walk.points().size() == 1);
}

TEST_CASE("The levels of a walk can be read at a distance") {
    LevelWalk walk;
    CHECK(walk.nearest(1) == nullptr);
    walk.add(view_at(0, 0, 1));
    walk.add(view_at(1, 1, 0.1F));
    walk.add(view_at(2, 2, 10));
    CHECK(walk.nearest(-3) == &walk.points()[0]);
    CHECK(walk.nearest(0.4) == &walk.points()[0]);
    CHECK(walk.nearest(0.6) == &walk.points()[1]);
    CHECK(walk.nearest(1.4) == &walk.points()[1]);
    CHECK(walk.nearest(9) == &walk.points()[2]);
    const std::string text = text_of(*walk.nearest(1));
    CHECK(text.find("1.00 m\n   63 Hz  -20.0 dB\n") == 0);
    CHECK(text.find("\n 8000 Hz  -20.0 dB") != std::string::npos);
}
