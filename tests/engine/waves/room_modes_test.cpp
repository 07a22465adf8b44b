#include "engine/waves/room_modes.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <glm/geometric.hpp>
#include <memory>
#include <numbers>
#include <vector>

#include "engine/waves/room_grid.h"
#include "tests/support/rooms.h"

using namespace aula;

namespace {

constexpr double kPi = std::numbers::pi;

const std::vector<Vec3> kPlaces{Vec3(0.03F, 0.02F, 0.01F)};

/// The modes up to about that number of an object around the origin.
struct Found {
    Found(const Object& object, double count, int threads = 1)
        : rays(std::make_shared<const RayScene>(
              test::grey_room(object, 0.1F, 0.1F, Vec3(0), Vec3(0.1F)))),
          wave_number(weyl_wave_number(count, test::volume_m3(object), test::surface_m2(object))),
          grid(rays, room_extent(*rays, kPlaces), kPlaces,
               static_cast<float>(cell_for_wave_number_m(wave_number))) {
        WorkerPool pool(threads);
        modes = find_room_modes(grid.cells(), wave_number, pool);
    }

    std::shared_ptr<const RayScene> rays;
    double wave_number;
    RoomGrid grid;
    RoomModes modes;
};

Object centred_box(const Vec3& size) { return test::box(size, 0, -size / 2.0F); }

std::vector<double> box_wave_numbers(const Vec3& size, double highest) {
    std::vector<double> result;
    const auto most = [&](float length) {
        return static_cast<int>(highest * double{length} / kPi) + 1;
    };
    for (int a = 0; a <= most(size.x); ++a) {
        for (int b = 0; b <= most(size.y); ++b) {
            for (int c = 0; c <= most(size.z); ++c) {
                result.push_back(
                    kPi * std::hypot(a / double{size.x}, b / double{size.y}, c / double{size.z}));
            }
        }
    }
    std::sort(result.begin(), result.end());
    return result;
}

/// Zeros of a function up to a bound, the one at 0 omitted.
template <typename F>
std::vector<double> zeros(const F& f, double highest) {
    std::vector<double> result;
    constexpr double kStep = 0.01;
    for (double x = kStep; x < highest; x += kStep) {
        if (f(x) * f(x + kStep) > 0) continue;
        double low = x;
        double high = x + kStep;
        for (int i = 0; i < 50; ++i) {
            const double middle = (low + high) / 2;
            (f(low) * f(middle) <= 0 ? high : low) = middle;
        }
        result.push_back(low);
    }
    return result;
}

std::vector<double> cylinder_wave_numbers(double radius, double height, double highest) {
    std::vector<double> result;
    for (int m = 0; m < highest * radius; ++m) {
        std::vector<double> across = zeros(
            [m](double x) {
                return m == 0 ? -std::cyl_bessel_j(1.0, x)
                              : (std::cyl_bessel_j(m - 1.0, x) - std::cyl_bessel_j(m + 1.0, x));
            },
            highest * radius);
        if (m == 0) across.push_back(0);
        for (const double x : across) {
            for (int q = 0; q * kPi / height < highest; ++q) {
                const double k = std::hypot(x / radius, q * kPi / height);
                result.insert(result.end(), m == 0 ? 1 : 2, k);
            }
        }
    }
    std::sort(result.begin(), result.end());
    return result;
}

std::vector<double> sphere_wave_numbers(double radius, double highest) {
    std::vector<double> result{0};
    for (unsigned l = 0; l < highest * radius; ++l) {
        for (const double x : zeros(
                 [l](double at) {
                     return l == 0 ? -std::sph_bessel(1, at)
                                   : std::sph_bessel(l - 1, at) -
                                         (l + 1) / at * std::sph_bessel(l, at);
                 },
                 highest * radius)) {
            result.insert(result.end(), 2 * l + 1, x / radius);
        }
    }
    std::sort(result.begin(), result.end());
    return result;
}

struct Deviation {
    double rms = 0;
    double largest = 0;
};

/// Relative deviations of the modes above the constant pressure.
Deviation deviation(const RoomModes& modes, const std::vector<double>& truth) {
    Deviation result;
    REQUIRE(truth.size() >= modes.count());
    for (std::size_t i = 1; i < modes.count(); ++i) {
        const double error = std::abs(std::sqrt(modes.wave_number2[i]) / truth[i] - 1);
        result.rms += error * error / static_cast<double>(modes.count() - 1);
        result.largest = std::max(result.largest, error);
    }
    result.rms = std::sqrt(result.rms);
    return result;
}

/// A closed vertical prism over a regular polygon around the z axis, with the cross-section of a
/// circle.
Object cylinder(float radius_m, float height_m, int sides) {
    const auto n = static_cast<float>(sides);
    const float corner_m = radius_m * std::sqrt(2 * std::numbers::pi_v<float> / n /
                                                std::sin(2 * std::numbers::pi_v<float> / n));
    Object object;
    object.vertices = {Vec3(0, 0, -height_m / 2), Vec3(0, 0, height_m / 2)};
    for (int i = 0; i < sides; ++i) {
        const float angle = 2 * std::numbers::pi_v<float> * static_cast<float>(i) / n;
        for (const float z : {-height_m / 2, height_m / 2}) {
            object.vertices.push_back(
                Vec3(corner_m * std::cos(angle), corner_m * std::sin(angle), z));
        }
    }
    for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(sides); ++i) {
        const std::uint32_t a = 2 + 2 * i;
        const std::uint32_t b = 2 + 2 * ((i + 1) % static_cast<std::uint32_t>(sides));
        object.triangles.insert(object.triangles.end(),
                                {{0, a, b}, {1, b + 1, a + 1}, {a, a + 1, b + 1}, {a, b + 1, b}});
    }
    object.triangle_materials.assign(object.triangles.size(), 0);
    return object;
}

Object turned(Object object, const Vec3& angles_rad) {
    const glm::mat3 rotation = Pose{Vec3(0), angles_rad.z, angles_rad.y, angles_rad.x}.rotation();
    for (Vec3& v : object.vertices) v = rotation * v;
    return object;
}

}  // namespace

TEST_CASE("room_modes: a box has its modes, none missing, within 0.1 %") {
    const Vec3 size = GENERATE(Vec3(5, 4, 3), Vec3(2, 2, 2.4F), Vec3(40, 25, 16), Vec3(3, 3, 3),
                               Vec3(9, 2, 2.5F));
    CAPTURE(size.x, size.y, size.z);
    const Found found(centred_box(size), 120);
    CHECK(found.grid.cells().total_volume_m3() ==
          Approx(double{size.x} * double{size.y} * double{size.z}).epsilon(1e-4));
    const std::vector<double> truth = box_wave_numbers(size, found.wave_number);
    const auto below = std::lower_bound(truth.begin(), truth.end(), 0.99 * found.wave_number);
    CHECK(found.modes.count() + 4 > static_cast<std::size_t>(below - truth.begin()));
    CHECK(deviation(found.modes, truth).largest < 1e-3);
}

TEST_CASE("room_modes: a turned box has the same modes: the grid turns with its walls") {
    const Vec3 size(5, 4, 3);
    const Found found(turned(centred_box(size), Vec3(0.1F, 0.26F, 0.35F)), 120);
    CHECK(deviation(found.modes, box_wave_numbers(size, found.wave_number)).largest < 2e-3);
}

TEST_CASE("room_modes: cut cells: a cylinder and a sphere have their modes") {
    SECTION("cylinder") {
        const Found found(turned(cylinder(2, 3, 64), Vec3(0, 0, 0.2F)), 120);
        const Deviation d =
            deviation(found.modes, cylinder_wave_numbers(2, 3, found.wave_number * 1.05));
        CHECK(d.rms < 5e-3);
        CHECK(d.largest < 1.5e-2);
    }
    SECTION("sphere") {
        const Object sphere = test::icosphere(2, 3);
        const double radius = std::cbrt(test::volume_m3(sphere) * 3 / 4 / kPi);
        const Found found(sphere, 120);
        const Deviation d =
            deviation(found.modes, sphere_wave_numbers(radius, found.wave_number * 1.05));
        CHECK(d.rms < 3e-3);
        CHECK(d.largest < 5e-3);
    }
}

TEST_CASE("room_modes: the same bytes with 1, 2 and 3 threads") {
    const Object room = test::l_shaped_room();
    const auto with = [&](int threads) {
        Object moved = room;
        for (Vec3& v : moved.vertices) v -= Vec3(1.5F);
        return Found(moved, 60, threads);
    };
    const Found one = with(1);
    for (const int threads : {2, 3}) {
        const Found other = with(threads);
        CHECK(other.modes.wave_number2 == one.modes.wave_number2);
        bool same = true;
        for (std::size_t i = 0; i < one.modes.shapes.cells(); ++i) {
            for (std::size_t j = 0; j < one.modes.count(); ++j) {
                same = same && one.modes.shapes.at(i, j) == other.modes.shapes.at(i, j);
            }
        }
        CHECK(same);
    }
}
