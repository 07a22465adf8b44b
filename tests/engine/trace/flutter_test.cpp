#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <glm/trigonometric.hpp>
#include <numbers>
#include <vector>

#include "engine/trace/specular_paths.h"
#include "tests/engine/trace/mirror_rooms.h"

namespace flutter_test {

using namespace aula;
using namespace aula::test;

namespace {

constexpr float kWidth_m = 2.5F;

/// A point of a corridor along x between walls at y = 0 and kWidth_m, turned about z.
Vec3 turned(const Vec3& p) {
    const float angle = glm::radians(10.0F);
    return {std::cos(angle) * p.x - std::sin(angle) * p.y,
            std::sin(angle) * p.x + std::cos(angle) * p.y, p.z};
}

const Vec3 kFrom(4, 1, 1.3F);
const Vec3 kTo(6, 1.6F, 1.7F);

void add_wall(Object& object, float y_begin, float y_end, std::uint32_t wall) {
    add_quad(object,
             {turned({0, y_begin, 0}), turned({12, y_end, 0}), turned({12, y_end, 3}),
              turned({0, y_begin, 3})},
             wall);
}

/// Two walls; the second is `apart_m` away at one end, and at an angle.
Scene two_walls(float apart_m, float angle_deg = 0) {
    Object object;
    add_wall(object, 0, 0, 0);
    add_wall(object, apart_m, apart_m + 12 * std::tan(glm::radians(angle_deg)), 0);
    Scene scene = scene_of({object});
    for (Material& m : scene.materials) m = material(0.05F, 0.05F);
    return scene;
}

std::vector<SoundPath> paths_of(const Scene& scene, Flutter flutter = Flutter::of_images) {
    const RayScene rays(scene);
    return SpecularPaths(rays, 3, kRadius_m, 1, flutter)
        .find(turned(kFrom), turned(kTo), false, Bands{})
        .paths;
}

}  // namespace

TEST_CASE("flutter between two walls has its image sources until they are 60 dB weaker") {
    const Scene scene = two_walls(kWidth_m);
    const std::vector<SoundPath> paths = paths_of(scene);
    CHECK(paths_of(scene, Flutter::of_rays).size() == 6);
    // 0.446 dB and the loss by distance: order 53 has 58.1 dB, 54 has 58.7, 56 has 59.9.
    REQUIRE(paths.size() == 2 * 56);
    std::vector<double> exact;
    for (int n = -56; n <= 56; ++n) {
        if (n == 0) continue;
        const double width{kWidth_m};
        const double at =
            n % 2 == 0 ? n * width + double{kFrom.y} : (n + 1) * width - double{kFrom.y};
        exact.push_back(
            std::hypot(double{kTo.x - kFrom.x}, at - double{kTo.y}, double{kTo.z - kFrom.z}));
    }
    std::sort(exact.begin(), exact.end());
    for (std::size_t i = 0; i < exact.size(); ++i) {
        CAPTURE(i);
        CHECK(double{paths[i].length_m} == Approx(exact[i]).epsilon(1e-5));
        const double energy =
            std::pow(0.95 * 0.95, paths[i].order) / (4 * std::numbers::pi * exact[i] * exact[i]);
        CHECK(double{paths[i].energy[3]} == Approx(energy).epsilon(1e-4));
    }
}

TEST_CASE("rays do not count the image sources of flutter") {
    const RayScene rays(two_walls(kWidth_m));
    const SpecularPaths specular(rays, 3, kRadius_m, 1, Flutter::of_images);
    CHECK(specular.listed_order() == 3);
    CHECK(specular.highest_order() == 56);
    // Hidden or not: behind the end of the walls nothing is audible.
    for (const Vec3& listener : {turned(kTo), Vec3(40, 30, 1)}) {
        const SpecularSound sound = specular.find(turned(kFrom), listener, false, Bands{});
        CHECK(sound.tried.size() == 2 * 53);
        for (const SoundPath& path : sound.paths)
            CHECK(sound.has_tried(path.key) == (path.order > 3));
    }
    // A path between the walls may be one of them, no other one above order 3.
    ImageTransform image;
    for (std::uint32_t order = 1; order <= 56; ++order) {
        image = image.then_from_source(specular.mirror_of_triangle(order % 2 == 0 ? 0 : 2));
        CHECK(specular.may_list(image));
    }
    CHECK_FALSE(specular.may_list(image.then_from_source(specular.mirror_of_triangle(2))));
}

TEST_CASE("walls that are nearly parallel flutter, other planes do not") {
    const auto has_flutter = [](const Scene& scene) {
        const std::vector<SoundPath> paths = paths_of(scene);
        return std::any_of(paths.begin(), paths.end(),
                           [](const SoundPath& path) { return path.order > 3; });
    };
    CHECK(has_flutter(two_walls(kWidth_m, 1)));
    CHECK_FALSE(has_flutter(two_walls(kWidth_m, 4)));
    // An order without image sources; walls that move; the two sides of a wall.
    const RayScene rays(two_walls(kWidth_m));
    CHECK(SpecularPaths(rays, 0, kRadius_m, 1, Flutter::of_images).candidate_count() == 0);
    Scene moving = two_walls(kWidth_m);
    moving.objects[0].movable = true;
    CHECK_FALSE(has_flutter(moving));
    const RayScene thin(two_walls(0.2F));
    CHECK(SpecularPaths(thin, 3, kRadius_m, 1, Flutter::of_images).highest_order() == 3);
}

TEST_CASE("what stands between two walls hides their flutter") {
    Scene scene = two_walls(kWidth_m);
    add_quad(
        scene.objects[0],
        {turned({5, 0.4F, 0}), turned({5, 2.1F, 0}), turned({5, 2.1F, 3}), turned({5, 0.4F, 3})},
        1);
    scene.materials[1] = material(1, 0);
    const std::vector<SoundPath> hidden = paths_of(scene);
    CHECK(hidden.size() < 60);
    CHECK(hidden.size() > 0);
}

}  // namespace flutter_test
