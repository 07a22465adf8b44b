#include "apps/window/view/patch_field.h"

#include <algorithm>
#include <catch2/catch.hpp>

#include "apps/window/view/sides.h"
#include "tests/support/test_scenes.h"

using namespace aula;

namespace {

PatchEnergy patch(const Vec3& direction, float energy) {
    return {{Vec3(0), Vec3(0.5F), direction}, Bands::filled(energy)};
}

}  // namespace

TEST_CASE("The largest energy has full level, 15 dB below half of it, and both fade") {
    PatchField field;
    field.cover({0, 0, 0}, {5, 4, 3}, 0.5F);
    const std::vector<PatchEnergy> patches{patch({1, 0, 0}, 1), patch({0, 0, 1}, 0.0316228F)};
    for (int i = 0; i < 100; ++i) field.update(patches, 2, 0.1);
    const auto count = field.texels().size();
    const auto level = [&](std::size_t direction) {
        return field.texels()[direction * count / 6].level;
    };
    CHECK(int{level(0)} == 255);
    CHECK(int{level(4)} == Approx(127).margin(1));  // whole numbers
    CHECK(std::count_if(field.texels().begin(), field.texels().end(),
                        [](const PatchField::Texel& t) { return t.occupied != 0; }) == 2 * 8);
    field.update({}, 2, 0.05);
    CHECK(int{level(0)} < 255);
    CHECK(int{level(0)} > 127);
    for (int i = 0; i < 100; ++i) field.update({}, 2, 0.1);
    CHECK(int{level(0)} == 0);
}

TEST_CASE("A large model is covered by larger texels") {
    PatchField field;
    field.cover({0, 0, 0}, {800, 600, 90}, 0.5F);
    CHECK(field.texels().size() < 2'000'000);
    CHECK(field.cell_m() > 0.5F);
}

TEST_CASE("The interior sides of a closed room are those that face inwards") {
    const Scene scene = test::small_room();
    const RayScene rays(scene);
    const std::vector<Vec3> inside{scene.sources[0].position};
    const Vec3 middle(2.5F, 2, 1.5F);
    const auto sides = interior_sides(rays, inside);
    for (std::uint32_t t = 0; t < rays.triangle_count(); ++t) {
        const auto& triangle = rays.triangle(t);
        const Vec3 inward = middle - triangle.vertices[0];
        const bool front = inward.x * triangle.normal.x + inward.y * triangle.normal.y +
                               inward.z * triangle.normal.z >
                           0;
        CHECK(int{sides[t]} == (front ? 1 : 2));
    }
}
