#include "apps/window/gl/colours.h"

#include <catch2/catch.hpp>
#include <glm/geometric.hpp>

using namespace aula;

TEST_CASE("Materials are told apart by colour or pattern") {
    CHECK(material_look("rough brick").pattern == SurfacePattern::bricks);
    CHECK(material_look("wood_floor").pattern == SurfacePattern::boards);
    CHECK(material_look("carpet").pattern == SurfacePattern::grains);
    CHECK(material_look("tile").pattern == SurfacePattern::tiles);
    CHECK(material_look("acoustic_tile").pattern == SurfacePattern::panels);
    CHECK(material_look("plaster").pattern == SurfacePattern::plain);
    // Names of models look as what they mean.
    CHECK(material_look("Wand_Ziegel.001").pattern == SurfacePattern::bricks);
    CHECK(material_look("Boden_Parkett").pattern == SurfacePattern::boards);
    CHECK(material_look("Vorhang").colour == material_look("curtain").colour);
    // Others differ by their names.
    const MaterialLook first = material_look("zzz");
    CHECK(first.colour == material_look("zzz").colour);
    CHECK(glm::distance(first.colour, material_look("yyy").colour) > 0);
}
