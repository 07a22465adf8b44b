#include "engine/direct/reflected_edge_paths.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <glm/geometric.hpp>
#include <memory>
#include <span>
#include <vector>

#include "engine/direct/direct_sound.h"
#include "engine/trace/specular_paths.h"
#include "tests/engine/direct/edge_path_scene.h"

namespace reflected_edge_paths_test {

using namespace aula;

namespace {

using aula::test::add_quad;

constexpr float kSpeed_m_s = 343.2F;
constexpr float kFar_m = 50;
constexpr unsigned kBeforeEdge = 1;
constexpr unsigned kAfterEdge = 2;
const Bands kNoLoss;
const Vec3 kSource(0.3F, -3, 1.2F);
const Vec3 kListener(1, 4, 1.5F);

/// A screen of 2.5 m in the plane y = 0 on the floor z = 0.
Scene screen_on_floor() {
    Object object;
    add_quad(object, {-kFar_m, 0, 0}, {kFar_m, 0, 0}, {kFar_m, 0, 2.5F}, {-kFar_m, 0, 2.5F});
    add_quad(object, {-kFar_m, -kFar_m, 0}, {kFar_m, -kFar_m, 0}, {kFar_m, kFar_m, 0},
             {-kFar_m, kFar_m, 0});
    Scene scene;
    scene.objects = {object};
    scene.materials = {{"rigid", Bands{}, Bands{}}};
    return scene;
}

/// The paths over the screen with a reflection at the floor.
std::vector<EdgePath> paths_of(const OrientedDirectivity& directivity) {
    const RayScene rays(screen_on_floor());
    DirectSound sound(rays, kSpeed_m_s, 2);
    const SpecularPaths images(rays, 1, 0.5F, 1);
    PairMemory memory;
    sound.begin_frame(false);
    sound.search(kSource, kListener, memory);
    sound.find(kSource, kListener, directivity, kNoLoss, memory);
    const ReflectedEdgePaths reflected(rays, sound.edges(), double{kSpeed_m_s});
    std::vector<EdgePath> paths;
    for (const ReflectedEdgePath& found : reflected.find(kSource, kListener, images.planes(), true,
                                                         directivity, kNoLoss, {}, false, memory)) {
        paths.push_back(found.path);
    }
    return paths;
}

/// From one place to the point of the floor from which its mirror image sees the other.
Vec3 towards_floor(const Vec3& from, const Vec3& to) {
    return glm::normalize(Vec3(to.x, to.y, -to.z) - from);
}

}  // namespace

TEST_CASE("a path over an edge leaves and arrives by its reflections at a plane") {
    const std::vector<EdgePath> paths = paths_of({});
    REQUIRE(paths.size() == 3);  // before the edge, after it, and both
    for (const EdgePath& path : paths) {
        CAPTURE(path.reflections);
        const bool is_before = (path.reflections & kBeforeEdge) != 0;
        const bool is_after = (path.reflections & kAfterEdge) != 0;
        REQUIRE(path.apexes.size() == 1U + is_before + is_after);
        const Vec3 edge = path.apexes[is_before ? 1 : 0];
        CHECK(std::abs(edge.y) < 1e-5F);
        CHECK(edge.z == Approx(2.5F));
        const Vec3 departure =
            is_before ? towards_floor(kSource, edge) : glm::normalize(edge - kSource);
        const Vec3 direction =
            is_after ? towards_floor(kListener, edge) : glm::normalize(edge - kListener);
        CHECK(glm::distance(path.departure, departure) < 1e-5F);
        CHECK(glm::distance(path.direction, direction) < 1e-5F);
    }
}

TEST_CASE("a path over an edge has the level of the source in the direction of its reflection") {
    // A cardioid that radiates down to the floor: the path by the floor is louder.
    const auto down = std::make_shared<EmissionSampler>(*Directivity::find("cardioid"));
    const OrientedDirectivity cardioid(down, Pose{Vec3(0), 0.4F, -1, 0}.rotation());
    const std::vector<EdgePath> equal = paths_of({});
    const std::vector<EdgePath> directed = paths_of(cardioid);
    REQUIRE(directed.size() == equal.size());
    for (const EdgePath& path : directed) {
        const auto same = std::find_if(equal.begin(), equal.end(), [&](const EdgePath& other) {
            return other.reflections == path.reflections;
        });
        REQUIRE(same != equal.end());
        const Bands factor = cardioid.factor(glm::normalize(path.apexes.front() - kSource));
        for (std::size_t b = 0; b < kBandCount; ++b) {
            const double ratio = std::norm(path.field[b]) / std::norm(same->field[b]);
            CHECK(ratio == Approx(double{factor[b]}).epsilon(1e-4));
        }
    }
}

}  // namespace reflected_edge_paths_test
