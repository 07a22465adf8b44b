#include "engine/rays/image_transform.h"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "engine/base/sampling.h"

using namespace aula;

namespace {

const Vec3 kSize(5, 4, 3);

}  // namespace

TEST_CASE("an image has one key from both ends and for every order of its planes") {
    // The walls of a box that is turned in space, with rounded coordinates.
    const Vec3 x = glm::normalize(Vec3(0.6F, 0.5F, 0.62F));
    const Vec3 y = glm::normalize(glm::cross(Vec3(0.3F, -1, 0.2F), x));
    const std::array<Vec3, 3> axes{x, y, glm::cross(x, y)};
    std::vector<MirrorPlane> walls;
    for (int wall = 0; wall < 6; ++wall) {
        const glm::dvec3 normal(axes[static_cast<std::size_t>(wall / 2)]);
        walls.push_back({glm::normalize(normal), wall % 2 == 0 ? 0 : double{kSize[wall / 2]}});
    }
    // Sequences of 6 reflections, no wall twice in a row; the image of a box counts its walls.
    std::map<std::array<int, 6>, std::set<std::uint64_t>> keys;
    std::size_t beside = 0;
    RandomStream random(11);
    for (int i = 0; i < 20000; ++i) {
        std::vector<std::size_t> planes;
        for (const int axis : {0, 1, 2}) {
            const auto from = static_cast<std::size_t>(2 * random.uniform());
            for (std::size_t k = 0; k < 2; ++k) {
                planes.push_back(static_cast<std::size_t>(2 * axis) + (from + k) % 2);
            }
        }
        // Interleaves the axes, each in its own order.
        for (std::size_t swaps = 0; swaps < 20; ++swaps) {
            const auto k = static_cast<std::size_t>(5 * random.uniform());
            if (planes[k] / 2 != planes[k + 1] / 2) std::swap(planes[k], planes[k + 1]);
        }
        ImageTransform from_listener;
        ImageTransform from_source;
        for (const std::size_t p : planes)
            from_listener = from_listener.then_from_listener(walls[p]);
        std::array<int, 6> first{};
        for (std::size_t k = 0; k < 6; ++k) {
            from_source = from_source.then_from_source(walls[planes[5 - k]]);
            auto& of_axis = first[planes[5 - k] / 2];
            of_axis = static_cast<int>(planes[5 - k] % 2);
        }
        CHECK(from_listener.key() == from_source.key());
        keys[first].insert(from_listener.key());
    }
    // Which wall of each axis comes first: eight images.
    CHECK(keys.size() == 8);
    std::set<std::uint64_t> all;
    for (const auto& [image, of_image] : keys) {
        CHECK(of_image.size() == 1);
        beside += all.count(*of_image.begin());
        all.insert(of_image.begin(), of_image.end());
    }
    CHECK(beside == 0);
    CHECK(all.count(0) == 0);
}

TEST_CASE("images of different orders of planes that do not commute have different keys") {
    const MirrorPlane a{{1, 0, 0}, 1};
    const MirrorPlane b{glm::normalize(glm::dvec3(1, 1, 0)), 2};
    const ImageTransform none;
    CHECK(none.then_from_listener(a).then_from_listener(b).key() !=
          none.then_from_listener(b).then_from_listener(a).key());
    // Walls at 60 degrees: both orders of three reflections are the same.
    const MirrorPlane c{glm::dvec3(0.5, std::sqrt(0.75), 0), 0.5};
    CHECK(none.then_from_listener(a).then_from_listener(c).then_from_listener(a).key() ==
          none.then_from_listener(c).then_from_listener(a).then_from_listener(c).key());
    CHECK(none.then_from_listener(a).key() != none.key());
}
