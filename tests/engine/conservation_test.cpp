// Mirrors, scattering and image sources together: nothing is counted twice and nothing is lost.

#include <catch2/catch.hpp>
#include <cmath>
#include <glm/geometric.hpp>
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

/// Bins and paths between two times. In 1/m2.
double all_between(const EnergyResponse& response, double begin_s, double end_s,
                   std::size_t band = 0) {
    double sum = test::energy_between(response, begin_s, end_s, band);
    for (const SoundPath& path : response.paths) {
        const double t = response.arrival_s(path);
        if (t >= begin_s && t < end_s) sum += double{path.energy[band]};
    }
    return sum;
}

/// Energy of all image sources of a box with equal walls, between two times: rho^n / (4 pi d^2); of
/// all orders, or of all but one.
double images_between(const Vec3& source, const Vec3& listener, double rho, double begin_m,
                      double end_m, int without_order = -1, const Vec3& size = kSize) {
    const auto along = [&](int axis, int n) {
        // Image n of the source: shifted by n lengths, and mirrored if n is odd.
        const double length = double{size[axis]};
        const double at = double{source[axis]};
        return (n % 2 == 0 ? n * length + at : (n + 1) * length - at) - double{listener[axis]};
    };
    const int most = static_cast<int>(end_m / 3) + 2;
    double sum = 0;
    for (int i = -most; i <= most; ++i) {
        for (int j = -most; j <= most; ++j) {
            for (int k = -most; k <= most; ++k) {
                const double d = std::hypot(along(0, i), along(1, j), along(2, k));
                const int order = std::abs(i) + std::abs(j) + std::abs(k);
                if (d < begin_m || d >= end_m || order == without_order) continue;
                sum += std::pow(rho, order) / (4 * std::numbers::pi * d * d);
            }
        }
    }
    return sum;
}

}  // namespace

TEST_CASE("without scattering the energy of a box is that of its image sources for every method") {
    // Whether paths come from image sources or, above the specular order, from rays.
    for (const int specular_order : {0, 3}) {
        Scene scene = test::grey_room(test::box(kSize), 0.2F, 0, kSource, kListener);
        scene.simulation.direct = true;
        scene.simulation.specular_order = specular_order;
        scene.simulation.listener_radius_m = 0.3F;
        scene.simulation.rays = 4000;
        for (const Estimator estimator : {Estimator::dpc, Estimator::patch}) {
            Propagation propagation(scene, test::with(scene, estimator, 0.12F, 0.1F));
            const double c = double{scene.medium.speed_of_sound_m_s()};
            for (const auto& [begin_s, end_s] : {std::pair(0.0, 0.04), std::pair(0.04, 0.1)}) {
                const test::Estimate e = test::estimate(test::restarts(
                    propagation, scene, 8, 3, [&, b = begin_s, n = end_s](const EnergyResponse& r) {
                        return all_between(r, b, n);
                    }));
                const double exact =
                    images_between(kSource, kListener, 0.8, begin_s * c, end_s * c);
                CAPTURE(specular_order, estimator_name(estimator), begin_s, e.mean,
                        e.standard_error, exact);
                // The sphere of 0.3 m averages 1 / d^2: R^2 / (5 d^2), 0.4 % of the first order.
                // The sphere may move arrivals across the border of an interval: 1 %.
                CHECK(std::abs(e.mean - exact) < test::kFamilyZ * e.standard_error + 0.01 * exact);
                // Companion: without the paths of one order, early or late.
                const double lacking = images_between(kSource, kListener, 0.8, begin_s * c,
                                                      end_s * c, begin_s == 0 ? 2 : 5);
                CHECK(std::abs(e.mean - lacking) >
                      test::kRefutedZ * e.standard_error + 0.01 * exact);
            }
        }
    }
}

TEST_CASE(
    "image sources of high orders and rays share the energy of a box without overlap or gap") {
    // Edges split the beam of an image source into parts with different orders of planes. In frame
    // 20 there are more of them than candidates are kept. Once axis-aligned, once turned and
    // shifted, with rounded coordinates.
    const Vec3 x = glm::normalize(Vec3(0.6F, 0.48F, 0.64F));
    const Vec3 y = glm::normalize(glm::cross(Vec3(0.3F, -1, 0.2F), x));
    const Vec3 z = glm::cross(x, y);
    for (const bool turned : {false, true}) {
        const auto at = [&](const Vec3& p) {
            return turned ? Vec3(7.3F, -2.1F, 4.4F) + p.x * x + p.y * y + p.z * z : p;
        };
        Object room = test::box(kSize);
        for (Vec3& vertex : room.vertices) vertex = at(vertex);
        Scene scene = test::grey_room(room, 0.1F, 0, at(kSource), at(kListener));
        scene.simulation.direct = true;
        scene.simulation.rays = 2000;
        const double c = double{scene.medium.speed_of_sound_m_s()};
        const double exact = images_between(kSource, kListener, 0.9, 0.02 * c, 0.1 * c);
        for (const int specular_order : {8, 10, 12}) {
            scene.simulation.specular_order = specular_order;
            for (const Estimator estimator : {Estimator::pt, Estimator::dpc, Estimator::patch}) {
                Propagation propagation(scene, test::with(scene, estimator, 0.12F, 0.1F));
                const test::Estimate e = test::estimate(test::restarts(
                    propagation, scene, 6, 20,
                    [](const EnergyResponse& r) { return all_between(r, 0.02, 0.1); }));
                CAPTURE(turned, specular_order, estimator_name(estimator), e.mean / exact,
                        e.standard_error / exact);
                // 1 %: spheres of 0.5 m at 7 m and more, arrivals on the borders. Parts that count
                // twice would add 2.5 % at order 8, 7 % at 10 and 10 % at 12.
                CHECK(std::abs(e.mean - exact) < test::kFamilyZ * e.standard_error + 0.01 * exact);
                CHECK(e.standard_error < 0.01 * exact);  // so that 5 % would be detected
            }
        }
    }
}

TEST_CASE("flutter between two hard walls and rays share its energy") {
    // Walls of absorption 0.05 at y = 0 and 4 m, others of 0.9: above order 3, three quarters of
    // the energy are flutter. Once turned.
    const Vec3 x = glm::normalize(Vec3(0.6F, 0.8F, 0));
    const Vec3 y(-x.y, x.x, 0);
    const auto turned = [&](const Vec3& p) { return p.x * x + p.y * y + Vec3(0, 0, p.z); };
    const double c = 343.2;
    const double exact = [&] {
        double sum = 0;
        const auto along = [](int axis, int n) {
            const double length{kSize[axis]};
            const double at{kSource[axis]};
            return (n % 2 == 0 ? n * length + at : (n + 1) * length - at) - double{kListener[axis]};
        };
        for (int i = -12; i <= 12; ++i)
            for (int j = -20; j <= 20; ++j)
                for (int k = -20; k <= 20; ++k) {
                    const double d = std::hypot(along(0, i), along(1, j), along(2, k));
                    if (d < 0.05 * c || d >= 0.15 * c) continue;
                    sum += std::pow(0.1, std::abs(i) + std::abs(k)) * std::pow(0.95, std::abs(j)) /
                           (4 * std::numbers::pi * d * d);
                }
        return sum;
    }();
    for (const bool is_turned : {false, true}) {
        Scene scene = test::grey_room(test::box(kSize), 0.9F, 0, kSource, kListener);
        scene.materials.push_back(scene.materials[0]);
        scene.materials[1].absorption = Bands::filled(0.05F);
        test::set_walls_across_y(scene.objects[0], 1);
        if (is_turned) {
            for (Vec3& vertex : scene.objects[0].vertices) vertex = turned(vertex);
            scene.sources[0].position = turned(kSource);
            scene.listener.pose.position = turned(kListener);
        }
        scene.simulation.direct = true;
        scene.simulation.rays = 4000;
        scene.simulation.specular_order = 3;
        for (const Estimator estimator : {Estimator::pt, Estimator::dpc, Estimator::patch}) {
            Propagation propagation(scene, test::with(scene, estimator, 0.16F, 0.2F));
            const test::Estimate e = test::estimate(
                test::restarts(propagation, scene, 6, 20,
                               [](const EnergyResponse& r) { return all_between(r, 0.05, 0.15); }));
            CAPTURE(is_turned, estimator_name(estimator), e.mean / exact, e.standard_error / exact);
            // 2.5 % (0.1 dB). What counts twice would add 70 %.
            CHECK(std::abs(e.mean - exact) < test::kFamilyZ * e.standard_error + 0.025 * exact);
            CHECK(e.standard_error < 0.02 * exact);
        }
    }
}

TEST_CASE("image sources of high orders and rays share the energy of rooms of other shapes") {
    // A prism over the corners of a floor, from z = 0 to 3 m.
    const auto prism = [](const std::vector<glm::vec2>& corners) {
        Object room;
        const auto n = static_cast<std::uint32_t>(corners.size());
        for (const float z : {0.0F, 3.0F}) {
            for (const glm::vec2& p : corners) room.vertices.emplace_back(p.x, p.y, z);
        }
        for (std::uint32_t k = 0; k < n; ++k) {
            const std::uint32_t next = (k + 1) % n;
            room.triangles.push_back({k, next, n + next});
            room.triangles.push_back({k, n + next, n + k});
            if (k == 0 || next == 0) continue;
            room.triangles.push_back({0, k, next});
            room.triangles.push_back({n, n + k, n + next});
        }
        room.triangle_materials.assign(room.triangles.size(), 0);
        return room;
    };
    const auto regular = [&](int corners, float radius_m) {
        std::vector<glm::vec2> at;
        for (int k = 0; k < corners; ++k) {
            const float angle =
                2 * std::numbers::pi_v<float> * static_cast<float>(k) / static_cast<float>(corners);
            at.emplace_back(radius_m * std::cos(angle), radius_m * std::sin(angle));
        }
        return prism(at);
    };
    // A wall across the box, from y = `from_y` to `to_y`.
    const auto with_screen = [](float from_y, float to_y) {
        Object room = test::box(kSize);
        const auto first = static_cast<std::uint32_t>(room.vertices.size());
        for (const Vec3& v : {Vec3(2.5F, from_y, 0), Vec3(2.5F, to_y, 0), Vec3(2.5F, to_y, 3),
                              Vec3(2.5F, from_y, 3)}) {
            room.vertices.push_back(v);
        }
        room.triangles.push_back({first, first + 1, first + 2});
        room.triangles.push_back({first, first + 2, first + 3});
        room.triangle_materials.resize(room.triangles.size(), 0);
        return room;
    };
    const auto finer = [](const Object& object) {
        return test::quartered(object, [](const Vec3& a, const Vec3& b) { return 0.5F * (a + b); });
    };
    struct Room {
        const char* name;
        Object object;
        Vec3 source, listener;
    };
    const std::vector<Room> rooms{
        {"screen", with_screen(0, 2), kSource, kListener},
        {"free screen", with_screen(1, 3), kSource, kListener},
        {"small faces", finer(finer(test::box(kSize))), kSource, kListener},
        {"L", test::l_shaped_room(), Vec3(5, 1.2F, 1.5F), Vec3(1.3F, 4.4F, 1.2F)},
        {"triangle", regular(3, 4), Vec3(2.1F, 0.3F, 1.4F), Vec3(-1.2F, 0.9F, 1.1F)},
        {"pentagon", regular(5, 3), Vec3(1.1F, 0.3F, 1.4F), Vec3(-1.2F, 0.9F, 1.1F)},
        {"wedge", prism({{0, 0}, {7, 0}, {6, 3.5F}, {0.8F, 1.1F}}), Vec3(5, 1.3F, 1.4F),
         Vec3(2, 0.8F, 1.1F)},
    };
    for (const Room& room : rooms) {
        Scene scene = test::grey_room(room.object, 0.1F, 0, room.source, room.listener);
        scene.simulation.direct = true;
        const auto all = [&](int specular_order, int rays) {
            scene.simulation.specular_order = specular_order;
            scene.simulation.rays = rays;
            Propagation propagation(scene, test::with(scene, Estimator::patch, 0.12F, 0.1F));
            return test::estimate(
                test::restarts(propagation, scene, 4, 20,
                               [](const EnergyResponse& r) { return all_between(r, 0.02, 0.1); }));
        };
        const test::Estimate by_rays = all(0, 8000);
        for (const int specular_order : {8, 12}) {
            const test::Estimate e = all(specular_order, 2000);
            const double error = std::hypot(e.standard_error, by_rays.standard_error);
            CAPTURE(room.name, specular_order, e.mean / by_rays.mean, error / by_rays.mean);
            // 2.5 % (0.1 dB): an image source is audible at a point, rays in a sphere of 0.5 m, in
            // part of which corners of the room hide images.
            CHECK(std::abs(e.mean - by_rays.mean) < test::kFamilyZ * error + 0.025 * by_rays.mean);
            CHECK(error < 0.005 * by_rays.mean);
        }
    }
}

TEST_CASE("in a hall of many planes no energy is missing before image sources are discovered") {
    // 1552 triangles, nearly all of them planes: sequences of order 1 are listed. The bumps turn
    // walls by up to 0.8 degrees: the sum over the images of the plane box is right within a per
    // cent.
    const Vec3 size(24, 18, 10);
    const Vec3 source(5.2F, 7.1F, 1.6F);
    const Vec3 listener(17.7F, 11.3F, 1.3F);
    Scene scene = test::grey_room(test::bumpy_box(size, 1.5F, 0.005F), 0.1F, 0, source, listener);
    scene.simulation.direct = true;
    scene.simulation.rays = 4000;
    scene.simulation.patch_size_m = 4;
    const double early_s = 0.08;
    const double exact = images_between(
        source, listener, 0.9, 0, early_s * double{scene.medium.speed_of_sound_m_s()}, -1, size);
    const auto early = [&](const EnergyResponse& r) { return all_between(r, 0, early_s) / exact; };
    const auto check = [](const std::vector<double>& samples) {
        const test::Estimate e = test::estimate(samples);
        CAPTURE(e.mean, e.standard_error);
        // 1 % for the bumps, 1 % for spheres of 0.5 m; 2 % because more probable sequences are
        // discovered earlier.
        CHECK(std::abs(e.mean - 1) < test::kFamilyZ * e.standard_error + 0.04);
        // Companion: a fifth is missing.
        CHECK(std::abs(e.mean - 0.8) > test::kFamilyZ * e.standard_error);
    };
    for (const int specular_order : {3, 5}) {
        scene.simulation.specular_order = specular_order;
        for (const Estimator estimator : test::kAllEstimators) {
            CAPTURE(specular_order, estimator_name(estimator));
            Propagation propagation(scene, test::with(scene, estimator, 0.1F, 0.5F));
            check(test::restarts(propagation, scene, 16, 1, early));
        }
        // Segments and entries are kept over frames in which their sequences become candidates.
        for (const Estimator estimator : {Estimator::dpc, Estimator::patch}) {
            CAPTURE(specular_order, estimator_name(estimator));
            Propagation propagation(scene, test::with(scene, estimator, 0.1F, 0.5F));
            check(test::restarts(propagation, scene, 6, 8, early));
        }
        // Rays from the listener: the source comes from far away in jumps.
        Propagation propagation(scene, test::with(scene, Estimator::patch, 0.1F, 0.5F));
        std::vector<double> samples;
        for (int i = 0; i < 12; ++i) {
            propagation.restart(derive_seed(test::test_seed(), i));
            FrameInput input = test::static_input(scene);
            for (const float x : {2.0F, 20.0F, source.x}) {
                input.sources[0].x = x;
                propagation.step(input);
            }
            samples.push_back(early(propagation.response(0)));
        }
        check(samples);
    }
}

TEST_CASE("a restart removes discovered image sources and traces different chains") {
    Scene scene = test::grey_room(test::bumpy_box(Vec3(12, 9, 5), 1, 0.005F), 0.1F, 0,
                                  Vec3(3, 4, 1.5F), Vec3(9, 5, 1.2F));
    scene.simulation.specular_order = 3;
    scene.simulation.rays = 500;
    Propagation propagation(scene, test::with(scene, Estimator::patch, 0.05F, 0.5F));
    const auto first_paths = [&](std::uint64_t seed) {
        propagation.restart(seed);
        propagation.step(test::static_input(scene));
        std::vector<std::uint64_t> keys;
        for (const SoundPath& path : propagation.response(0).paths) keys.push_back(path.key);
        return keys;
    };
    const auto one = first_paths(1);
    for (int frame = 0; frame < 5; ++frame) propagation.step(test::static_input(scene));
    CHECK(propagation.response(0).paths.size() > one.size());
    CHECK(first_paths(2) != one);
    CHECK(first_paths(1) == one);
}

TEST_CASE("a hall of many planes gives identical responses with any number of threads") {
    Scene scene = test::grey_room(test::bumpy_box(Vec3(12, 9, 5), 1, 0.005F), 0.1F, 0.05F,
                                  Vec3(3, 4, 1.5F), Vec3(9, 5, 1.2F));
    scene.simulation.specular_order = 4;
    for (const Estimator estimator : test::kAllEstimators) {
        Simulation simulation = test::with(scene, estimator, 0.1F, 0.2F);
        simulation.threads = 1;
        Propagation one(scene, simulation);
        simulation.threads = 3;
        Propagation three(scene, simulation);
        for (int frame = 0; frame < 6; ++frame) {
            FrameInput input = test::static_input(scene);
            input.listeners[0].x += 0.05F * static_cast<float>(std::min(frame, 3));
            one.step(input);
            three.step(input);
            CHECK(test::same_bits(one.response(0), three.response(0)));
        }
    }
}

TEST_CASE("the specular order changes the method that finds a path, not the energy") {
    // Partly specular walls that differ by band.
    Scene scene = test::grey_room(test::box(kSize), 0.2F, 0.5F, kSource, kListener);
    scene.materials[0].absorption = {{0.05F, 0.1F, 0.2F, 0.3F, 0.1F, 0.4F, 0.2F, 0.6F}};
    scene.materials[0].scattering = {{0, 0.1F, 0.2F, 0.4F, 0.5F, 0.7F, 0.9F, 1}};
    scene.simulation.direct = true;
    scene.simulation.rays = 2000;
    std::vector<std::vector<test::Estimate>> totals;  // [specular order][band]
    for (const int specular_order : {0, 3}) {
        scene.simulation.specular_order = specular_order;
        Propagation propagation(scene, test::with(scene, Estimator::patch, 0.25F, 0.1F));
        std::vector<std::vector<double>> samples(kBandCount);
        test::restarts(propagation, scene, 12, 3, [&](const EnergyResponse& r) {
            for (std::size_t b = 0; b < kBandCount; ++b) {
                samples[b].push_back(all_between(r, 0, 0.25, b));
            }
            return 0.0;
        });
        totals.emplace_back();
        for (const auto& of_band : samples) totals.back().push_back(test::estimate(of_band));
    }
    for (std::size_t b = 0; b < kBandCount; ++b) {
        const test::Estimate& most = totals[1][b];  // with the fewest paths from rays
        const test::Estimate& e = totals[0][b];
        const double error = std::hypot(e.standard_error, most.standard_error);
        CAPTURE(b, e.mean, most.mean, error);
        // The sphere of 0.5 m: R^2 / (5 d^2) of the first order's part, below 1 %.
        CHECK(std::abs(e.mean - most.mean) < test::kFamilyZ * error + 0.01 * most.mean);
    }
    // The companion: in band 0, with mirrors only, image sources of three orders have more than a
    // third of the energy.
    Simulation without = test::with(scene, Estimator::patch, 0.25F, 0.1F);
    without.specular = false;
    Propagation propagation(scene, without);
    propagation.step(test::static_input(scene));
    CHECK(all_between(propagation.response(0), 0, 0.25) < 0.66 * totals[1][0].mean);
}

TEST_CASE("energy is conserved for any scattering, including image sources") {
    // Lossless: late energy is c P / V, including the image sources, which arrive first.
    for (const float scattering : {0.0F, 0.05F, 0.5F, 1.0F}) {
        Scene scene = test::grey_room(test::box(kSize), 0, scattering, kSource, kListener);
        scene.simulation.specular_order = 3;
        scene.simulation.rays = 2000;
        const double exact = double{scene.medium.speed_of_sound_m_s()} / 60 * 0.15;
        for (const Estimator estimator : {Estimator::dpc, Estimator::patch}) {
            Propagation propagation(scene, test::with(scene, estimator, 0.2F, 0.1F));
            const test::Estimate e = test::estimate(
                test::restarts(propagation, scene, 10, 3,
                               [](const EnergyResponse& r) { return all_between(r, 0.05, 0.2); }));
            CAPTURE(scattering, estimator_name(estimator), e.mean, e.standard_error, exact);
            // There is one image per volume of the room: their number in a shell of 17 to 69 m
            // differs from the ratio of the volumes by less than 1 %.
            CHECK(std::abs(e.mean - exact) < test::kFamilyZ * e.standard_error + 0.015 * exact);
            CHECK(std::abs(e.z(1.15 * exact)) > test::kRefutedZ);  // companion
        }
    }
}

TEST_CASE(
    "source and listener are interchangeable with partly specular walls that differ by band") {
    Scene there = test::grey_room(test::l_shaped_room(), 0.2F, 0.3F, Vec3(5, 1.5F, 1.5F),
                                  Vec3(1.5F, 5, 1.2F));
    there.materials.push_back({"soft",
                               {{0.1F, 0.2F, 0.4F, 0.6F, 0.8F, 0.9F, 0.9F, 1}},
                               {{0.2F, 0.3F, 0.5F, 0.8F, 1, 1, 0.1F, 0.5F}}});
    there.materials[0].scattering = {{0, 0.1F, 0.3F, 0.5F, 0.7F, 0.9F, 0.2F, 1}};
    // One wing absorbing, one hard: the two directions differ in everything but the sum.
    Object& room = there.objects[0];
    for (std::size_t t = 0; t < room.triangles.size(); ++t) {
        float x = 0;
        for (const std::uint32_t v : room.triangles[t]) x += room.vertices[v].x / 3;
        room.triangle_materials[t] = x > 3 ? 1 : 0;
    }
    Scene back = there;
    std::swap(back.sources[0].position, back.listener.pose.position);
    const auto totals = [](const Scene& scene) {
        Propagation propagation(scene, test::with(scene, Estimator::patch, 0.3F, 0.2F));
        std::vector<std::vector<double>> samples(kBandCount);
        test::restarts(propagation, scene, 12, 4, [&](const EnergyResponse& r) {
            for (std::size_t b = 0; b < kBandCount; ++b) {
                samples[b].push_back(all_between(r, 0, 0.3, b));
            }
            return 0.0;
        });
        std::vector<test::Estimate> estimates;
        for (const auto& of_band : samples) estimates.push_back(test::estimate(of_band));
        return estimates;
    };
    const auto one = totals(there);
    const auto other = totals(back);
    for (std::size_t b = 0; b < kBandCount; ++b) {
        const double error = std::hypot(one[b].standard_error, other[b].standard_error);
        CAPTURE(b, one[b].mean, other[b].mean, error);
        // Patches of 0.5 m, 1 %.
        CHECK(std::abs(one[b].mean - other[b].mean) < test::kFamilyZ * error + 0.01 * one[b].mean);
        CHECK(error < 0.05 * one[b].mean);  // so that a difference would be detected
    }
    // Companion: the response of a listener beside the source in the other wing differs.
    Scene elsewhere = there;
    elsewhere.listener.pose.position = Vec3(1.5F, 1.5F, 1.2F);
    const auto third = totals(elsewhere);
    CHECK(std::abs(third[0].mean - one[0].mean) > 0.1 * one[0].mean);
}
