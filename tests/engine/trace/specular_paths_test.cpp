#include "engine/trace/specular_paths.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <set>
#include <utility>
#include <vector>

#include "engine/base/sampling.h"
#include "tests/engine/trace/mirror_rooms.h"

using namespace aula;
using namespace aula::test;

namespace {

struct Image {
    int order;
    double length_m;
    glm::dvec3 offset;  ///< from the listener
    double share;       ///< product of (1 - s)(1 - alpha)
};

/// Allen and Berkley's images of a source in a box.
std::vector<Image> box_images(const Scene& scene, const Vec3& size, const Vec3& source,
                              const Vec3& listener, int max) {
    std::vector<Image> images;
    const auto share = [&](int wall) {
        const Material& m = scene.materials[static_cast<std::size_t>(wall)];
        return (1 - double{m.absorption[0]}) * (1 - double{m.scattering[0]});
    };
    struct AxisImage {
        int order;
        double at, share;
    };
    std::array<std::vector<AxisImage>, 3> along;
    for (int axis = 0; axis < 3; ++axis) {
        for (int n = -max; n <= max; ++n) {
            for (int q = 0; q < 2; ++q) {
                const int order = std::abs(2 * n - q);
                if (order > max) continue;
                along[static_cast<std::size_t>(axis)].push_back(
                    {order, (1 - 2 * q) * double{source[axis]} + 2 * n * double{size[axis]},
                     std::pow(share(2 * axis), std::abs(n - q)) *
                         std::pow(share(2 * axis + 1), std::abs(n))});
            }
        }
    }
    for (const AxisImage& x : along[0]) {
        for (const AxisImage& y : along[1]) {
            for (const AxisImage& z : along[2]) {
                const int order = x.order + y.order + z.order;
                if (order > max) continue;
                const glm::dvec3 offset = glm::dvec3(x.at, y.at, z.at) - glm::dvec3(listener);
                images.push_back({order, glm::length(offset), offset, x.share * y.share * z.share});
            }
        }
    }
    return images;
}

/// One path for each image and one image for each path.
void check_against_images(const std::vector<SoundPath>& paths, std::vector<Image> images,
                          double attenuation_per_m) {
    REQUIRE(paths.size() == images.size());
    for (const SoundPath& path : paths) {
        const glm::dvec3 offset = glm::dvec3(path.direction) * double{path.length_m};
        const auto image =
            std::min_element(images.begin(), images.end(), [&](const Image& a, const Image& b) {
                return glm::distance(a.offset, offset) < glm::distance(b.offset, offset);
            });
        const double energy = image->share * std::exp(-attenuation_per_m * image->length_m) /
                              (4 * std::numbers::pi * image->length_m * image->length_m);
        CHECK(path.order == image->order);
        // Rounding of floats, of some products of them, of a unit vector times up to 20 m.
        CHECK(double{path.length_m} == Approx(image->length_m).epsilon(2e-7));
        CHECK(double{path.energy[0]} == Approx(energy).epsilon(2e-6));
        CHECK(glm::distance(image->offset, offset) < 5e-6);
        images.erase(image);
    }
}

std::array<int, 4> per_order(const std::vector<SoundPath>& paths) {
    std::array<int, 4> count{};
    for (const SoundPath& p : paths) ++count[static_cast<std::size_t>(p.order)];
    return count;
}

}  // namespace

TEST_CASE("a shoebox has the image sources of the closed form, orders 0 to 3") {
    const Scene scene = scene_of({mirror_box(kSize)});
    const RayScene rays(scene);
    const SpecularPaths specular(rays, 3, kRadius_m, 1);
    const auto paths = specular.find(kSource, kListener, true, Bands::filled(0.01F)).paths;
    CHECK(per_order(paths) == std::array<int, 4>{1, 6, 18, 38});
    CHECK(ids(paths).size() == paths.size());
    const double attenuation{0.01F};
    check_against_images(paths, box_images(scene, kSize, kSource, kListener, 3), attenuation);
    // Companion: a source 1 mm away has other lengths.
    const auto other = specular.find(kSource + Vec3(1e-3F, 0, 0), kListener, true, Bands{}).paths;
    CHECK(double{paths[1].length_m} != Approx(double{other[1].length_m}).epsilon(2e-7));
}

TEST_CASE("image sources are right for any source and listener in a shoebox") {
    const Scene scene = scene_of({mirror_box(kSize)});
    const RayScene rays(scene);
    const SpecularPaths specular(rays, 3, kRadius_m, 1);
    RandomStream random(1);
    const auto random_point = [&] {
        const auto xy = random.uniform_2d();
        return Vec3(xy[0], xy[1], random.uniform()) * (kSize - 0.02F) + 0.01F;
    };
    for (int i = 0; i < 100; ++i) {
        const Vec3 source = random_point();
        const Vec3 listener = random_point();
        check_against_images(specular.find(source, listener, true, Bands{}).paths,
                             box_images(scene, kSize, source, listener, 3), 0);
    }
}

TEST_CASE("paths that meet an edge or a corner exactly count once") {
    const RayScene rays(scene_of({mirror_box(Vec3(4))}));
    const SpecularPaths specular(rays, 3, kRadius_m, 1);
    const Vec3 centre(2);
    const auto paths = specular.find(centre, Vec3(2, 2, 1), true, Bands{}).paths;
    CHECK(per_order(paths) == std::array<int, 4>{1, 6, 18, 38});
    // Both at the centre: zero distance, but a finite level.
    const auto coincident = specular.find(centre, centre, true, Bands{}).paths;
    CHECK(per_order(coincident) == std::array<int, 4>{1, 6, 18, 38});
    CHECK(coincident[0].length_m == 0);
    CHECK(double{coincident[0].energy[0]} == Approx(1 / (4 * std::numbers::pi * 0.01)));
    CHECK(coincident[0].direction == Vec3(0));
    CHECK(coincident[0].departure == Vec3(0));
}

TEST_CASE("in free field there is only direct sound") {
    const RayScene rays(scene_of({}));
    SpecularPaths specular(rays, 3, kRadius_m, 1);
    specular.discover({0, 0, 0}, 0);
    const auto paths = specular.find({3, 4, 0}, {0, 0, 0}, true, Bands{}).paths;
    REQUIRE(paths.size() == 1);
    CHECK(paths[0].order == 0);
    CHECK(paths[0].length_m == 5);
    CHECK(double{paths[0].energy[7]} == Approx(1 / (100 * std::numbers::pi)));
    CHECK(paths[0].direction == Vec3(0.6F, 0.8F, 0));
    CHECK(specular.find({3, 4, 0}, {0, 0, 0}, false, Bands{}).paths.empty());
}

TEST_CASE("order 0 has no reflections") {
    const RayScene rays(scene_of({mirror_box(kSize)}));
    const SpecularPaths specular(rays, 0, kRadius_m, 1);
    CHECK(specular.find(kSource, kListener, true, Bands{}).paths.size() == 1);
    CHECK(specular.find(kSource, kListener, false, Bands{}).paths.empty());
}

TEST_CASE("walls that scatter or absorb everything have no images") {
    for (const Material& m : {material(0.2F, 1), material(1, 0)}) {
        Scene scene = scene_of({mirror_box(kSize)});
        for (Material& wall : scene.materials) wall = m;
        const RayScene rays(scene);
        CHECK(SpecularPaths(rays, 3, kRadius_m, 1)
                  .find(kSource, kListener, true, Bands{})
                  .paths.size() == 1);
    }
}

TEST_CASE("a screen blocks the direct sound and reflects on both sides") {
    Object screen;
    add_screen(screen, 2.5F, 1, 3, 0.5F, 2.5F);
    const RayScene rays(scene_of({screen}));
    const SpecularPaths specular(rays, 2, kRadius_m, 1);
    CHECK(specular.find({1, 2, 1.5F}, {4, 2, 1.5F}, true, Bands{}).paths.empty());
    for (const float x : {1.0F, 4.0F}) {
        const auto paths = specular.find({x, 1.9F, 1.5F}, {x, 2.1F, 1.5F}, true, Bands{}).paths;
        REQUIRE(paths.size() == 2);
        CHECK(paths[1].order == 1);
        CHECK(double{paths[1].length_m} == Approx(std::sqrt(9 + 0.04)));
    }
    // Beyond its edge nothing is blocked or reflected.
    CHECK(specular.find({1, 3.2F, 1.5F}, {4, 3.2F, 1.5F}, true, Bands{}).paths.size() == 1);
}

TEST_CASE("a partition lets paths through its opening only") {
    Object room = mirror_box(kSize);
    add_screen(room, 2.5F, 0, 1.5F, 0, 3);  // opening from y = 1.5 to 2.5, full height
    add_screen(room, 2.5F, 2.5F, 4, 0, 3);
    const RayScene rays(scene_of({room}));
    const SpecularPaths specular(rays, 1, kRadius_m, 1);
    // Through the opening: the direct sound, floor, ceiling and both end walls. The paths by the
    // side walls would cross the partition.
    const auto through = specular.find({1, 2, 1.5F}, {4.2F, 2.1F, 1.5F}, true, Bands{}).paths;
    CHECK(per_order(through) == std::array<int, 4>{1, 4, 0, 0});
    // Both on one side, beside the opening: the partition hides and replaces the far wall.
    const auto beside = specular.find({1, 0.6F, 1.5F}, {1.4F, 0.8F, 1}, true, Bands{}).paths;
    CHECK(per_order(beside) == std::array<int, 4>{1, 6, 0, 0});
}

TEST_CASE("an L-shaped room hides images behind its corner") {
    // The L: x 0..6, y 0..2 and x 0..2, y 0..6; without floor and ceiling.
    Object room;
    const auto wall = [&](float x0, float y0, float x1, float y1) {
        add_quad(room, {Vec3(x0, y0, 0), Vec3(x1, y1, 0), Vec3(x1, y1, 3), Vec3(x0, y0, 3)});
    };
    wall(0, 0, 6, 0);
    wall(6, 0, 6, 2);
    wall(6, 2, 2, 2);
    wall(2, 2, 2, 6);
    wall(2, 6, 0, 6);
    wall(0, 6, 0, 0);
    const RayScene rays(scene_of({room}));
    const SpecularPaths specular(rays, 2, kRadius_m, 1);
    const auto paths = specular.find({5, 1.4F, 1.5F}, {1.2F, 5, 1.5F}, true, Bands{}).paths;
    // The inner corner hides the source itself and its images in either outer wall; the image in
    // both is audible, by x = 0 (y = 3.8) and y = 0 (x = 3.6).
    REQUIRE(paths.size() == 1);
    CHECK(paths[0].order == 2);
    CHECK(double{paths[0].length_m} == Approx(std::hypot(5 + 1.2, 1.4 + 5)));
    // Companion: without the inner walls there are more.
    Object open;
    std::swap(open, room);
    wall(0, 0, 6, 0);
    wall(0, 6, 0, 0);
    const RayScene open_rays(scene_of({room}));
    CHECK(SpecularPaths(open_rays, 2, kRadius_m, 1)
              .find({5, 1.4F, 1.5F}, {1.2F, 5, 1.5F}, true, Bands{})
              .paths.size() == 4);
}

TEST_CASE("no image is audible through a closed wall, even if its path meets the wall's edge") {
    // Two rooms, 5 x 4 x 3 m and 4 x 4 x 3 m, and the wall between them at x = 5, once in each. The
    // path by y = 0 reaches its wall at x = 5 exactly, the one by the ceiling at x = 5.
    Object there = mirror_box({4, 4, 3});
    for (Vec3& v : there.vertices) v += Vec3(5, 0, 0);
    const RayScene rays(scene_of({mirror_box(kSize), there}));
    const SpecularPaths specular(rays, 3, kRadius_m, 1);
    const Vec3 source(8, 3, 2);
    const Vec3 listener(3, 2, 1.5F);
    CHECK(specular.find(source, listener, true, Bands{}).paths.empty());
    CHECK(specular.find(listener, source, true, Bands{}).paths.empty());
    // At other positions, and where first orders meet the wall's four edges up to rounding.
    RandomStream random(3);
    for (int i = 0; i < 300; ++i) {
        const auto xy = random.uniform_2d();
        const Vec3 here = Vec3(xy[0], xy[1], random.uniform()) * (kSize - 0.02F) + 0.01F;
        const auto yz = random.uniform_2d();
        Vec3 other = Vec3(5.01F, 0.01F, 0.01F) +
                     Vec3(3.98F * random.uniform(), 3.98F * yz[0], 2.98F * yz[1]);
        CHECK(specular.find(other, here, true, Bands{}).paths.empty());
        // Distances from y = 0 in proportion to those from x = 5.
        other.y = here.y * (other.x - 5) / (5 - here.x);
        if (!(other.y > 0.01F && other.y < 3.99F)) continue;
        CHECK(specular.find(other, here, true, Bands{}).paths.empty());
        other.y += i % 2 == 0 ? 1e-4F : -1e-4F;
        CHECK(specular.find(other, here, true, Bands{}).paths.empty());
    }
    // Companion: without the wall they are audible.
    Object open = mirror_box({9, 4, 3});
    const RayScene open_rays(scene_of({open}));
    CHECK(SpecularPaths(open_rays, 1, kRadius_m, 1)
              .find(source, listener, true, Bands{})
              .paths.size() == 7);
}

TEST_CASE("coincident duplicate faces reflect once") {
    Object walls = mirror_box(kSize);
    for (Vec3& v : walls.vertices) {
        for (int axis = 0; axis < 3; ++axis) v[axis] = std::min(v[axis], kSize[axis]);
    }
    const RayScene rays(scene_of({mirror_box(kSize), walls}));
    const auto paths =
        SpecularPaths(rays, 3, kRadius_m, 1).find(kSource, kListener, true, Bands{}).paths;
    CHECK(per_order(paths) == std::array<int, 4>{1, 6, 18, 38});
}

TEST_CASE("near a wall levels are finite, and on it there is no reflection in it") {
    const RayScene rays(scene_of({mirror_box(kSize)}));
    const SpecularPaths specular(rays, 3, kRadius_m, 1);
    for (const float gap_m : {0.0F, 1e-6F, 1e-4F, 1e-3F, 1e-2F}) {
        const Vec3 source(1, 2, gap_m);
        const Vec3 listener(1, 2.01F, gap_m);
        const auto paths = specular.find(source, listener, true, Bands{}).paths;
        CHECK(per_order(paths)[0] == 1);
        CHECK(per_order(paths)[1] == (gap_m < 5e-4F ? 5 : 6));
        for (const SoundPath& p : paths) {
            CHECK(p.energy[0] <= 1 / (4 * std::numbers::pi_v<float> * 0.01F));
            CHECK(std::isfinite(p.energy[0]));
            // Within 0.1 m directions fade.
            CHECK(glm::length(p.direction) ==
                  Approx(std::min(1.0F, p.length_m / 0.1F)).epsilon(1e-5));
        }
    }
}

TEST_CASE("near a source the spreading is limited, the attenuation has the length of the path") {
    const RayScene rays(scene_of({mirror_box(kSize)}));
    const SpecularPaths specular(rays, 0, kRadius_m, 1);
    for (const float length_m : {0.01F, 0.09F, 0.5F}) {
        const Vec3 listener = kSource + Vec3(length_m, 0, 0);
        const auto paths = specular.find(kSource, listener, true, Bands::filled(2)).paths;
        REQUIRE(paths.size() == 1);
        const double spread_m = std::max(0.1, double{length_m});
        // Rounding of the positions.
        CHECK(double{paths[0].energy[0]} ==
              Approx(std::exp(-2 * double{length_m}) / (4 * std::numbers::pi * spread_m * spread_m))
                  .epsilon(1e-5));
    }
}

TEST_CASE("neither a source nor a listener on a wall has a reflection in it") {
    const RayScene rays(scene_of({mirror_box(kSize)}));
    const SpecularPaths specular(rays, 1, kRadius_m, 1);
    const Vec3 on_floor(1, 2, 1e-4F);
    const Vec3 above(2, 1, 1.5F);
    for (const auto& [source, listener] :
         {std::pair(on_floor, above), std::pair(above, on_floor)}) {
        const auto paths = specular.find(source, listener, true, Bands{}).paths;
        CHECK(per_order(paths) == std::array<int, 4>{1, 5, 0, 0});
    }
    // Companion: away from it there are six.
    CHECK(per_order(specular.find(above, above + 0.5F, true, Bands{}).paths)[1] == 6);
}

TEST_CASE("planes smaller than 0.01 m2 have no image sources") {
    const auto reflections = [](float side_m, int pieces) {
        Object mirror;
        for (int i = 0; i < pieces; ++i) {
            const float y = 0.5F * static_cast<float>(i);
            add_screen(mirror, 0, y - side_m / 2, y + side_m / 2, -side_m / 2, side_m / 2);
        }
        const RayScene rays(scene_of({mirror}));
        const SpecularPaths specular(rays, 1, kRadius_m, 1);
        CHECK(specular.leaves_to_rays(1) == (static_cast<float>(pieces) * side_m * side_m < 0.01F));
        return specular.find({2, 0.01F, 0}, {1, -0.01F, 0}, false, Bands{}).paths.size();
    };
    CHECK(reflections(0.101F, 1) == 1);
    CHECK(reflections(0.099F, 1) == 0);
    CHECK(reflections(0.099F, 2) == 1);  // coplanar: one plane of 0.0196 m2
}

TEST_CASE("a plate on the floor replaces the floor in its area") {
    // So thin that a ray towards the floor hits its top, of material 5.
    Object plate = mirror_box({3, 2, 1.2e-3F});
    for (Vec3& v : plate.vertices) v += Vec3(1, 1, 0);
    const RayScene rays(scene_of({mirror_box(kSize), plate}));
    const SpecularPaths specular(rays, 1, kRadius_m, 1);
    for (const float x : {2.5F, 0.4F}) {
        const Vec3 source(x, 1.9F, 1.5F);
        const Vec3 listener(x, 2.1F, 1.5F);
        const auto paths = specular.find(source, listener, true, Bands{}).paths;
        CHECK(per_order(paths)[1] == 6);
        // By the floor or the plate: from below.
        int below = 0;
        for (const SoundPath& path : paths) {
            if (path.order != 1 || path.direction.z > -0.9F) continue;
            ++below;
            const double share = x > 1 ? 0.65 * 0.9 : 0.7 * 0.92;  // material 4 is the floor
            const double spread = 4 * std::numbers::pi * std::pow(double{path.length_m}, 2);
            CHECK(double{path.energy[0]} * spread == Approx(share).epsilon(1e-5));
        }
        CHECK(below == 1);
    }
}

TEST_CASE("a mirror that leaves the plane of another still reflects") {
    Object still;
    add_screen(still, 0, -50, 0, -50, 50);
    Object moving;
    add_screen(moving, 0, 0, 50, -50, 50);
    moving.path = Trajectory{};
    moving.path->points = {{0, {.position = {0, 0, 0}}}, {1, {.position = {-1, 0, 0}}}};
    RayScene rays(scene_of({still, moving}));
    SpecularPaths specular(rays, 2, kRadius_m, 1);
    const auto reflection_m = [&](float y) {
        const auto paths = specular.find({2, y, 0}, {1, y, 0}, false, Bands{}).paths;
        REQUIRE(paths.size() == 1);
        return double{paths[0].length_m};
    };
    CHECK(reflection_m(-3) == Approx(3));
    CHECK(reflection_m(3) == Approx(3));
    rays.move(1);
    specular.scene_moved();
    CHECK(reflection_m(-3) == Approx(3));
    CHECK(reflection_m(3) == Approx(5));
}

TEST_CASE("a plate that another leaves behind becomes a facet") {
    // Two coplanar plates of 0.008 m2.
    Object still;
    add_screen(still, 0, -0.05F, 0.05F, 0, 0.08F);
    Object moving;
    add_screen(moving, 0, 0.1F, 0.2F, 0, 0.08F);
    moving.path = Trajectory{};
    moving.path->points = {{0, {.position = {0, 0, 0}}}, {1, {.position = {-1, 0, 0}}}};
    RayScene rays(scene_of({still, moving}));
    SpecularPaths specular(rays, 1, kRadius_m, 1);
    const auto reflections = [&] {
        return specular.find({2, 0, 0.04F}, {1, 0, 0.04F}, false, Bands{}).paths.size();
    };
    CHECK(reflections() == 1);
    rays.move(1);
    specular.scene_moved();
    CHECK(reflections() == 0);
    CHECK(specular.leaves_to_rays(1));
}

TEST_CASE("images follow a moving object and keep their identity") {
    Object wall;
    add_screen(wall, 5, -50, 50, -50, 50);
    Object mirror;
    add_screen(mirror, 0, -50, 50, -50, 50);
    mirror.path = Trajectory{};
    mirror.path->points = {{0, {.position = {0, 0, 0}}}, {1, {.position = {-1, 0, 0}}}};
    RayScene rays(scene_of({wall, mirror}));
    SpecularPaths specular(rays, 2, kRadius_m, 1);
    const auto before = specular.find({2, 0, 0}, {1, 0, 0}, true, Bands{}).paths;
    REQUIRE(before.size() == 5);
    CHECK(double{before[1].length_m} == Approx(3));

    rays.move(1);
    specular.scene_moved();
    const auto after = specular.find({2, 0, 0}, {1, 0, 0}, true, Bands{}).paths;
    REQUIRE(after.size() == 5);
    CHECK(double{after[1].length_m} == Approx(5));
    CHECK(ids(after) == ids(before));

    // A wall that moves between them.
    mirror.path->points[1].pose.position = {1.5F, 0, 0};
    RayScene between(scene_of({wall, mirror}));
    SpecularPaths cut(between, 2, kRadius_m, 1);
    between.move(1);
    cut.scene_moved();
    CHECK(cut.find({2, 0, 0}, {1, 0, 0}, true, Bands{}).paths.empty());
}
