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

constexpr double kFar_m = 1000;

std::vector<SoundPath> paths_of(const Scene& scene, double flutter_m = kFar_m) {
    const RayScene rays(scene);
    return SpecularPaths(rays, 3, kRadius_m, 1, flutter_m)
        .find(turned(kFrom), turned(kTo), false, Bands{})
        .paths;
}

}  // namespace

TEST_CASE("flutter between two walls has its image sources until they are 60 dB weaker") {
    const Scene scene = two_walls(kWidth_m);
    const std::vector<SoundPath> paths = paths_of(scene);
    CHECK(paths_of(scene, 0).size() == 6);
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
    const SpecularPaths specular(rays, 3, kRadius_m, 1, kFar_m);
    CHECK(specular.listed_order() == 3);
    CHECK(specular.highest_order() == 56);
    const SpecularSound sound = specular.find(turned(kFrom), turned(kTo), false, Bands{});
    CHECK(sound.tried.size() == 2 * 53);
    for (const SoundPath& path : sound.paths) CHECK(sound.has_tried(path.key) == (path.order > 3));
    // Images that the sphere of the listener does not meet are not tried. At its edge rays
    // may meet the sphere although no path meets its centre.
    CHECK(specular.find(turned(kFrom), Vec3(40, 30, 1), false, Bands{}).tried.empty());
    const SpecularSound beside =
        specular.find(turned(kFrom), turned({12 + kRadius_m / 2, 1, 1.5F}), false, Bands{});
    CHECK(beside.paths.size() < beside.tried.size());
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
    CHECK(SpecularPaths(rays, 0, kRadius_m, 1, kFar_m).highest_order() == 0);
    Scene moving = two_walls(kWidth_m);
    moving.objects[0].movable = true;
    CHECK_FALSE(has_flutter(moving));
    const RayScene thin(two_walls(0.2F));
    CHECK(SpecularPaths(thin, 3, kRadius_m, 1, kFar_m).highest_order() == 3);
}

TEST_CASE("sources share the images of flutter") {
    const RayScene rays(two_walls(kWidth_m));
    const SpecularPaths specular(rays, 3, kRadius_m, 1, kFar_m);
    for (const std::size_t sources : {1U, 8U, 64U, 2000U}) {
        const SpecularSound sound =
            specular.find(turned(kFrom), turned(kTo), false, Bands{}, nullptr, sources);
        CAPTURE(sources);
        CHECK(sound.tried.size() == std::min<std::size_t>(2 * 53, 1024 / sources / 2 * 2));
        CHECK(sound.paths.size() == sound.tried.size() + 6);
    }
}

TEST_CASE("what moves between two walls does not end their flutter") {
    Scene scene = two_walls(kWidth_m);
    Object screen;
    add_quad(screen,
             {turned({-1, 1, -1}), turned({13, 1, -1}), turned({13, 1, 4}), turned({-1, 1, 4})}, 0);
    screen.movable = true;
    scene.objects.push_back(screen);
    const auto pairs_of = [](const Scene& of) {
        const RayScene rays(of);
        return flutter_pairs(rays, ScenePlanes(rays), kFar_m);
    };
    const std::vector<FlutterPair> pairs = pairs_of(scene);
    REQUIRE(pairs.size() == 1);
    CHECK(pairs[0].order == 56);
    // Companion: a screen that stands still flutters with either wall.
    scene.objects.back().movable = false;
    CHECK(pairs_of(scene).size() == 2);
}

TEST_CASE("flutter ends with the response") {
    const Scene scene = two_walls(kWidth_m);
    const std::vector<SoundPath> all = paths_of(scene);
    const std::vector<SoundPath> paths = paths_of(scene, 50);
    const auto is_within = [](const SoundPath& path) { return path.length_m <= 50; };
    CHECK(std::ssize(paths) == std::count_if(all.begin(), all.end(), is_within));
    CHECK(paths.size() > 30);
}

TEST_CASE("every storey has its flutter, through floors there is none") {
    // Rooms of 5 m by 4 m, 2.5 m high, above each other.
    constexpr int kStoreys = 12;
    Object object;
    for (int storey = 0; storey < kStoreys; ++storey) {
        for (const float z : {0.0F, kWidth_m}) {
            const float at = 2.8F * static_cast<float>(storey) + z;
            add_quad(object, {Vec3{0, 0, at}, {5, 0, at}, {5, 4, at}, {0, 4, at}}, 0);
        }
    }
    Scene scene = scene_of({object});
    for (Material& m : scene.materials) m = material(0.02F, 0);
    const RayScene rays(scene);
    const SpecularPaths specular(rays, 3, kRadius_m, 1, kFar_m);
    for (int storey = 0; storey < kStoreys; ++storey) {
        const float floor_m = 2.8F * static_cast<float>(storey);
        const SpecularSound sound =
            specular.find({1, 1, floor_m + 1}, {4, 3, floor_m + 1.5F}, false, Bands{});
        CAPTURE(storey);
        CHECK(sound.paths.size() == 200);
        // Orders 1 and 2 of all planes, 3 to 100 of two planes: other storeys cost nothing.
        CHECK(sound.reflections == 24 + 2 * 24 * 23 + 2 * (100 * 101 / 2 - 3));
    }
    CHECK(flutter_pairs(rays, specular.planes(), kFar_m).size() == kStoreys);
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
