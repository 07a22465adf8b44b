// Imperfect geometry: faces of either orientation, duplicate, without area, with cracks, open;
// sources and listeners on surfaces, inside solids, at the same position.

#include <catch2/catch.hpp>
#include <cmath>
#include <glm/geometric.hpp>
#include <initializer_list>
#include <numbers>
#include <vector>

#include "aula/engine/propagation.h"
#include "engine/base/sampling.h"
#include "tests/support/measure.h"
#include "tests/support/rooms.h"
#include "tests/support/statistics.h"

using namespace aula;

namespace {

const Vec3 kSize(5, 4, 3);
const Vec3 kSource(1.2F, 1.1F, 1.5F);
const Vec3 kListener(3.7F, 2.9F, 1.2F);
const std::initializer_list<Estimator> kUnbiased{Estimator::dpc, Estimator::patch};

/// Uniform in a box.
Vec3 random_point(RandomStream& random, const Vec3& low, const Vec3& high) {
    const auto xy = random.uniform_2d();
    return low + Vec3(xy[0], xy[1], random.uniform()) * (high - low);
}

void add_triangle(Object& object, const Vec3& a, const Vec3& b, const Vec3& c,
                  std::uint32_t material = 0) {
    const auto first = static_cast<std::uint32_t>(object.vertices.size());
    object.vertices.insert(object.vertices.end(), {a, b, c});
    object.triangles.push_back({first, first + 1, first + 2});
    object.triangle_materials.push_back(material);
}

/// Triangles of about `size_m` in a box, of the given number of materials.
Object clutter(RandomStream& random, int count, float size_m, const Vec3& low, const Vec3& high,
               std::uint32_t materials = 1) {
    Object object;
    for (int i = 0; i < count; ++i) {
        const Vec3 at = random_point(random, low, high);
        add_triangle(object, at, at + size_m * uniform_direction(random.uniform_2d()),
                     at + size_m * uniform_direction(random.uniform_2d()),
                     static_cast<std::uint32_t>(random.bits() % materials));
    }
    return object;
}

/// The late energy in a lossless room relative to c P / V.
test::Estimate late_ratio(const Scene& scene, Estimator estimator, double volume_m3) {
    Propagation propagation(scene, test::with(scene, estimator, 0.35F, 0.1F));
    auto samples = test::restarts(propagation, scene, 12, 3, [](const EnergyResponse& r) {
        return test::energy_between(r, 0.15, 0.35);
    });
    const double exact = double{scene.medium.speed_of_sound_m_s()} / volume_m3 * (0.35 - 0.15);
    for (double& x : samples) x /= exact;
    return test::estimate(samples);
}

/// Late energy must be c P / V.
void check_lossless(const Scene& scene, std::initializer_list<Estimator> estimators,
                    double systematic = 5e-3) {
    for (const Estimator estimator : estimators) {
        const test::Estimate e = late_ratio(scene, estimator, 60);
        CAPTURE(estimator_name(estimator), e.mean, e.standard_error);
        // Systematic: patches' areas from samples; besides, after 3 frames the modes of the room
        // are below 1e-3.
        CHECK(std::abs(e.mean - 1) < test::kFamilyZ * e.standard_error + systematic);
        CHECK(std::abs(e.z(1.15)) > test::kRefutedZ);  // companion
    }
}

Scene lossless(const Object& object, float scattering = 1, const Vec3& source = kSource,
               const Vec3& listener = kListener) {
    return test::grey_room(object, 0, scattering, source, listener);
}

}  // namespace

TEST_CASE("normals may face either way") {
    Object box = test::box(kSize);
    for (std::size_t t = 0; t < box.triangles.size(); t += 2) {
        std::swap(box.triangles[t][0], box.triangles[t][1]);
    }
    check_lossless(lossless(box), kUnbiased);
}

TEST_CASE("duplicate and degenerate triangles change nothing") {
    Object box = test::box(kSize);
    const auto triangles = box.triangles;
    for (const auto& [a, b, c] : triangles) {
        box.triangles.push_back({a, b, c});
        box.triangles.push_back({b, a, c});
        box.triangles.push_back({a, a, b});
    }
    box.vertices.push_back((box.vertices[0] + box.vertices[1]) * 0.5F);
    box.triangles.push_back({0, 1, 8});  // three points on a line
    box.triangle_materials.assign(box.triangles.size(), 0);
    check_lossless(lossless(box), kUnbiased);
}

TEST_CASE("thin surfaces do not change the late energy of a room, in any orientation") {
    RandomStream random(derive_seed(test::test_seed(), 1));
    for (const auto& [count, size_m] : {std::pair(12, 1.0F), std::pair(300, 0.3F)}) {
        CAPTURE(count, size_m);
        Scene scene = lossless(test::box(kSize));
        scene.objects.push_back(clutter(random, count, size_m, Vec3(0.6F), kSize - Vec3(0.6F)));
        check_lossless(scene, kUnbiased, 0.01);
    }
}

TEST_CASE("hollow objects do not change the late energy of a room, with any interior") {
    // Closed boxes as thick as a book: half of the upward faces in a cell are insides of bottoms.
    Scene scene = lossless(test::box(kSize));
    const Vec3 book(0.3F, 0.3F, 0.06F);
    int books = 0;
    for (const float x : {0.6F, 1.7F, 2.6F, 3.1F, 4.1F}) {
        for (const float y : {0.55F, 1.6F, 2.6F, 3.6F}) {
            for (const float z : {0.3F, 0.7F, 1.8F, 2.55F}) {
                scene.objects.push_back(test::box(book, 0, Vec3(x, y, z)));
                ++books;
            }
        }
    }
    const double volume_m3 = 60 - books * double{book.x * book.y * book.z};
    const test::Estimate e = late_ratio(scene, Estimator::patch, volume_m3);
    CAPTURE(e.mean, e.standard_error);
    // Systematic: parts of patches have some hundred hits each.
    CHECK(std::abs(e.mean - 1) < test::kFamilyZ * e.standard_error + 0.01);
    // Companion: with the insides of the books, a ninth of all faces, it would be lower by that
    // share.
    CHECK(std::abs(e.z(0.9)) > test::kRefutedZ);
}

TEST_CASE("mirrors among scattering surfaces neither remove nor add energy") {
    RandomStream random(derive_seed(test::test_seed(), 2));
    Scene scene = lossless(test::box(kSize));
    scene.materials.push_back({"mirror", Bands{}, Bands{}});
    scene.materials.push_back({"half", Bands{}, Bands::filled(0.5F)});
    scene.objects.push_back(clutter(random, 300, 0.3F, Vec3(0.6F), kSize - Vec3(0.6F), 3));
    check_lossless(scene, kUnbiased, 0.01);
}

TEST_CASE("a wall of mirrors and scattering strips, both in each patch, is lossless") {
    // Floor and ceiling in strips of 0.1 m, every other one a mirror.
    Scene scene = lossless(test::box(kSize));
    scene.materials.push_back({"mirror", Bands{}, Bands{}});
    Object& box = scene.objects[0];
    box.triangles.erase(box.triangles.begin(), box.triangles.begin() + 4);
    box.triangle_materials.resize(8);
    for (std::uint32_t i = 0; i < 50; ++i) {
        const float x0 = 0.1F * static_cast<float>(i);
        const float x1 = 0.1F * static_cast<float>(i + 1);
        for (const float z : {0.0F, kSize.z}) {
            add_triangle(box, Vec3(x0, 0, z), Vec3(x1, 0, z), Vec3(x1, 4, z), i % 2);
            add_triangle(box, Vec3(x0, 0, z), Vec3(x1, 4, z), Vec3(x0, 4, z), i % 2);
        }
    }
    check_lossless(scene, kUnbiased, 0.01);
}

TEST_CASE("a source on a wall, an edge or a corner sends all its energy into the room") {
    for (const Vec3& source : {Vec3(2, 1.5F, 0), Vec3(0, 1.5F, 0), Vec3(5, 4, 3)}) {
        CAPTURE(source.x, source.y, source.z);
        check_lossless(lossless(test::box(kSize), 1, source), kUnbiased);
    }
}

TEST_CASE("a mirror doubles the direct sound of a source or listener on it") {
    for (const bool is_listener : {false, true}) {
        const Vec3 position(2, 1.5F, 0);
        Scene scene = test::grey_room(test::box(kSize), 0, 0, is_listener ? kListener : position,
                                      is_listener ? position : kListener);
        scene.simulation.direct = true;
        scene.simulation.specular_order = 1;
        Propagation propagation(scene, test::with(scene, Estimator::patch, 0.1F));
        propagation.step(test::static_input(scene));
        std::vector<SoundPath> paths = propagation.response(0).paths;
        std::erase_if(paths, [](const SoundPath& path) { return path.order > 1; });  // flutter
        REQUIRE(paths.size() == 7);  // direct, six walls
        REQUIRE(paths[0].order == 0);
        CHECK(paths[1].order == 1);
        // A millimetre above it the paths' lengths differ by less than two millimetres.
        CHECK(double{paths[1].energy[0]} == Approx(double{paths[0].energy[0]}).epsilon(2e-3));
    }
}

TEST_CASE("a listener near or on a wall, an edge or a corner receives the energy of the room") {
    for (const Vec3& listener :
         {Vec3(2, 1.5F, 0.05F), Vec3(2, 1.5F, 0), Vec3(0, 1.5F, 0), Vec3(5, 4, 3),
          Vec3(4.99F, 3.99F, 2.99F), Vec3(4.9F, 3.9F, 2.9F)}) {
        CAPTURE(listener.x, listener.y, listener.z);
        check_lossless(lossless(test::box(kSize), 1, kSource, listener), kUnbiased);
    }
}

TEST_CASE("a source near or in a corner gives the room its energy") {
    for (const Vec3& source : {Vec3(5, 4, 3), Vec3(4.99F, 3.99F, 2.99F), Vec3(4.9F, 3.9F, 2.9F)}) {
        CAPTURE(source.x, source.y, source.z);
        check_lossless(lossless(test::box(kSize), 1, source, kListener), kUnbiased);
    }
}

TEST_CASE("on a wall whose normal faces outwards the position is moved into the room as well") {
    Object box = test::box(kSize);
    for (auto& t : box.triangles) std::swap(t[0], t[1]);
    check_lossless(lossless(box, 1, Vec3(2, 1.5F, 0), Vec3(0, 2, 1)), {Estimator::patch});
}

TEST_CASE("a thin wall between two rooms is opaque at any position") {
    for (const float at_m : {5.0F, 5.1F, 5.25F, 5.37F}) {
        Scene scene = test::grey_room(test::box(Vec3(10, 4, 3)), 0.2F, 1, kSource, Vec3(8, 3, 1));
        scene.objects.push_back(test::box(Vec3(0.1F, 4, 3), 0, Vec3(at_m, 0, 0)));
        Propagation propagation(scene, test::with(scene, Estimator::patch, 0.3F));
        FrameInput input = test::static_input(scene);
        for (int f = 0; f < 4; ++f) propagation.step(input);
        CHECK(test::total(propagation.response(0)) == 0);
        input.listeners[0] = Vec3(4, 3, 1);
        propagation.step(input);
        CHECK(test::total(propagation.response(0)) > 0);  // companion
    }
}

TEST_CASE("inside a solid there is little energy, and around it none is lost") {
    Scene scene = lossless(test::box(kSize));
    scene.objects.push_back(test::box(Vec3(1.03F, 0.97F, 0.8F), 0, Vec3(2.13F, 1.61F, 0)));
    const double solid_m3 = 1.03 * 0.97 * 0.8;
    const test::Estimate e = late_ratio(scene, Estimator::patch, 60 - solid_m3);
    CHECK(std::abs(e.mean - 1) < test::kFamilyZ * e.standard_error + 0.01);
    scene.listener.pose.position = Vec3(2.6F, 2, 0.4F);
    // Patches of the floor that are partly under it contribute a little.
    const test::Estimate inside = late_ratio(scene, Estimator::patch, 60 - solid_m3);
    CHECK(inside.mean < 0.1);
}

TEST_CASE(
    "a source at the listener's position, in the middle or on a wall, has a finite response") {
    for (const Vec3& position : {kListener, Vec3(2, 1.5F, 0), Vec3(0)}) {
        Scene scene = test::grey_room(test::box(kSize), 0.2F, 0.3F, position, position);
        scene.simulation.direct = true;
        scene.simulation.specular_order = 3;
        for (const Estimator estimator : test::kAllEstimators) {
            Propagation propagation(scene, test::with(scene, estimator, 0.2F));
            for (int f = 0; f < 3; ++f) propagation.step(test::static_input(scene));
            const EnergyResponse& response = propagation.response(0);
            CAPTURE(estimator_name(estimator));
            CHECK(test::fault(response) == "");
            REQUIRE(!response.paths.empty());
            // The direct sound from 0.1 m, the minimum distance.
            CHECK(double{response.paths[0].energy[0]} ==
                  Approx(1 / (4 * std::numbers::pi * 0.01)).epsilon(1e-5));
        }
    }
}

TEST_CASE("T-junctions and cracks as wide as rounding errors leak negligible energy") {
    // The floor is divided into strips whose corners touch no corner of the walls, moved by up to
    // 10 um.
    Object box = test::box(kSize);
    RandomStream random(derive_seed(test::test_seed(), 3));
    box.triangles.erase(box.triangles.begin(), box.triangles.begin() + 2);
    box.triangle_materials.resize(box.triangles.size());
    for (int i = 0; i < 17; ++i) {
        const float x0 = 5.0F * static_cast<float>(i) / 17;
        const float x1 = 5.0F * static_cast<float>(i + 1) / 17;
        const float z = 1e-5F * random.uniform();
        add_triangle(box, Vec3(x0, 0, z), Vec3(x1, 0, z), Vec3(x1, 4, z));
        add_triangle(box, Vec3(x0, 0, z), Vec3(x1, 4, z), Vec3(x0, 4, z));
    }
    check_lossless(lossless(box), kUnbiased);
}

TEST_CASE("for any triangles responses are finite, not negative, and the same with two threads") {
    RandomStream random(derive_seed(test::test_seed(), 4));
    for (int trial = 0; trial < 16; ++trial) {
        Scene scene =
            test::grey_room(Object{}, random.uniform(), random.uniform(), Vec3(0), Vec3(0));
        scene.materials.push_back({"mirror", Bands::filled(random.uniform()), Bands{}});
        scene.materials.push_back({"stone", Bands{}, Bands::filled(1)});
        for (float& x : scene.materials[0].absorption.value) x = random.uniform();
        for (float& x : scene.materials[0].scattering.value) x = random.uniform();
        Object soup;
        const int count = 1 + static_cast<int>(random.bits() % 100);
        const float size_m = std::pow(10.0F, -2 + 2.5F * random.uniform());
        soup = clutter(random, count, size_m, Vec3(-3), Vec3(3), 3);
        for (auto& t : soup.triangles) {
            // Some share vertices, some have no area.
            if (random.uniform() < 0.3F)
                t[0] = static_cast<std::uint32_t>(random.bits() % soup.vertices.size());
            if (random.uniform() < 0.1F) t[1] = t[2];
        }
        scene.objects = {soup};
        if (random.uniform() < 0.5F) scene.objects.push_back(test::box(Vec3(8), 0, Vec3(-4)));
        const auto somewhere = [&] {
            const float kind = random.uniform();
            const Vec3 a = soup.vertices[random.bits() % soup.vertices.size()];
            const Vec3 b = soup.vertices[random.bits() % soup.vertices.size()];
            if (kind < 0.2F) return a;
            if (kind < 0.3F) return (a + b) * 0.5F;
            return random_point(random, Vec3(-4), Vec3(4));
        };
        scene.sources[0].position = somewhere();
        scene.listener.pose.position =
            random.uniform() < 0.1F ? scene.sources[0].position : somewhere();
        scene.simulation.direct = true;
        scene.simulation.rays = 60;
        scene.simulation.specular_order = static_cast<int>(random.bits() % 4);
        for (const Estimator estimator : test::kAllEstimators) {
            CAPTURE(trial, estimator_name(estimator), count, size_m);
            std::vector<EnergyResponse> results;
            for (const int threads : {1, 2}) {
                Simulation simulation = test::with(scene, estimator, 0.1F, 0.1F);
                simulation.threads = threads;
                Propagation propagation(scene, simulation);
                for (int f = 0; f < 2; ++f) propagation.step(test::static_input(scene));
                results.push_back(propagation.response(0));
            }
            CHECK(test::fault(results[0]) == "");
            CHECK(test::same_bits(results[0], results[1]));
        }
    }
}
