#include "engine/waves/wave_response.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <glm/geometric.hpp>
#include <memory>
#include <numbers>
#include <optional>
#include <vector>

#include "engine/base/sampling.h"
#include "engine/waves/room_waves.h"
#include "engine/waves/wall_admittance.h"
#include "tests/engine/waves/exact_box.h"
#include "tests/support/rooms.h"

namespace wave_response_test {

using namespace aula;
using Complex = std::complex<double>;

namespace {

constexpr double kSpeed_m_s = 343.2;

double wave_number_of(double hz) { return 2 * std::numbers::pi * hz / kSpeed_m_s; }

/// A box from the origin with a material for each wall: x low, x high, y low, ...
Scene box_scene(const Vec3& size, const std::array<float, 6>& absorption) {
    Object object = test::box(size);
    Scene scene = test::grey_room(object, 0, 0, size * 0.3F, size * 0.6F);
    scene.materials.clear();
    for (const float a : absorption) {
        Material material;
        material.absorption = Bands::filled(a);
        scene.materials.push_back(material);
    }
    Object& box = scene.objects.at(0);
    for (std::size_t t = 0; t < box.triangles.size(); ++t) {
        for (int axis = 0; axis < 3; ++axis) {
            for (const float side : {0.0F, size[axis]}) {
                const bool lies = std::all_of(
                    box.triangles[t].begin(), box.triangles[t].end(), [&](std::uint32_t v) {
                        return std::abs(box.vertices[v][axis] - side) < 1e-5F;
                    });
                if (lies) {
                    box.triangle_materials[t] =
                        static_cast<std::uint32_t>(2 * axis + (side > 0 ? 1 : 0));
                }
            }
        }
    }
    return scene;
}

/// The field of a room with about that number of modes, without other limits.
RoomWaves waves_of(const Scene& scene, const Vec3& place, double modes, double cells = 1) {
    const auto rays = std::make_shared<const RayScene>(scene);
    WorkerPool pool(1);
    const WaveLimits limits{
        .modes = modes, .highest_hz = 1e4, .schroeder = 1e4, .cells = cells, .most_open = 0.05};
    return RoomWaves::find(rays, std::vector{place}, kSpeed_m_s, limits, pool).value();
}

/// The pressure with the direct sound.
Complex pressure(const WaveResponse& response, double wave_number) {
    return response.reverberant(wave_number)[0] +
           direct_field(double{glm::length(response.from_source)}, {0, wave_number})[0];
}

test::DampedBox damped_box(const Vec3& size, const std::array<float, 6>& absorption) {
    test::DampedBox box{size, {}};
    for (std::size_t wall = 0; wall < 6; ++wall) {
        box.admittance[wall / 2][wall % 2] = admittance_of_absorption(double{absorption[wall]});
    }
    return box;
}

/// Places in a box, away from its walls and from a source.
std::vector<Vec3> places_in(const Vec3& size, const Vec3& source, std::size_t count) {
    std::vector<Vec3> places;
    RandomStream random(3);
    while (places.size() < count) {
        Vec3 at(0);
        for (int axis = 0; axis < 3; ++axis) {
            at[axis] = size[axis] * (0.08F + 0.84F * random.uniform());
        }
        const bool apart = glm::distance(at, source) > 0.15F * size.z + 0.4F;
        if (apart && std::abs(at.x - source.x) > 0.06F * size.x) places.push_back(at);
    }
    return places;
}

double db(double energy) { return 10 * std::log10(energy); }

double correlation(const std::vector<double>& a, const std::vector<double>& b) {
    const auto n = static_cast<double>(a.size());
    double ma = 0;
    double mb = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        ma += a[i] / n;
        mb += b[i] / n;
    }
    double aa = 0;
    double bb = 0;
    double ab = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        aa += (a[i] - ma) * (a[i] - ma);
        bb += (b[i] - mb) * (b[i] - mb);
        ab += (a[i] - ma) * (b[i] - mb);
    }
    return ab / std::sqrt(aa * bb);
}

}  // namespace

TEST_CASE("wave_response: octaves and responses of boxes are those of the exact field") {
    struct Case {
        const char* name;
        Vec3 size;
        std::array<float, 6> absorption;
    };
    const Case room = GENERATE(Case{"living room", {5, 4, 3}, {.1F, .1F, .1F, .1F, .1F, .1F}},
                               Case{"bathroom", {2, 2, 2.4F}, {.05F, .05F, .05F, .05F, .05F, .05F}},
                               Case{"carpet", {5, 4, 3}, {.05F, .05F, .05F, .05F, .6F, .05F}},
                               Case{"absorbing wall", {5, 4, 3}, {.9F, .1F, .1F, .1F, .1F, .1F}},
                               Case{"low room", {6, 4.5F, 2.5F}, {.3F, .3F, .3F, .3F, .3F, .3F}});
    CAPTURE(room.name);
    const RoomWaves waves =
        waves_of(box_scene(room.size, room.absorption), room.size * 0.3F, WaveLimits{}.modes);
    const Vec3 source = room.size * Vec3(.24F, .275F, .5F);
    const std::vector<Vec3> receivers = places_in(room.size, source, 20);
    std::vector<double> hz;
    std::vector<double> wave_numbers;
    for (double f = 20; f < 200; f += 0.5) {
        hz.push_back(f);
        wave_numbers.push_back(wave_number_of(f));
    }
    const auto truth = test::exact_box(damped_box(room.size, room.absorption), source, receivers,
                                       wave_numbers, wave_number_of(650));
    std::vector<double> correlations;
    for (std::size_t r = 0; r < receivers.size(); ++r) {
        const WaveResponse response = waves.response(source, receivers[r]).value();
        std::array<double, 2> sum{};  // [octave]
        std::array<double, 2> exact{};
        std::vector<double> levels;
        std::vector<double> exact_levels;
        for (std::size_t i = 0; i < hz.size(); ++i) {
            const double energy = std::norm(pressure(response, wave_numbers[i]));
            levels.push_back(db(energy));
            exact_levels.push_back(db(std::norm(truth[r][i])));
            if (hz[i] < 44 || hz[i] > 177) continue;
            sum[hz[i] < 88 ? 0 : 1] += energy;
            exact[hz[i] < 88 ? 0 : 1] += std::norm(truth[r][i]);
        }
        CAPTURE(r, receivers[r].x, receivers[r].y, receivers[r].z);
        CHECK(std::abs(db(sum[0] / exact[0])) < 1);
        CHECK(std::abs(db(sum[1] / exact[1])) < 1);
        correlations.push_back(correlation(levels, exact_levels));
    }
    std::sort(correlations.begin(), correlations.end());
    CHECK(correlations[0] > 0.97);
    CHECK(correlations[10] > 0.99);
}

TEST_CASE("wave_response: the poles of a box have the exact frequencies and decays") {
    const Vec3 size(5, 4, 3);
    const std::array<float, 6> absorption{.1F, .1F, .2F, .1F, .3F, .1F};
    const RoomWaves waves = waves_of(box_scene(size, absorption), size * 0.3F, 120);
    REQUIRE(waves.poles().size() == 1);  // the octaves have equal coefficients
    const std::vector<DampedPole>& poles = waves.poles()[0].poles;
    const test::DampedBox box = damped_box(size, absorption);
    int compared = 0;
    for (int a = 0; a < 5; ++a) {
        for (int b = 0; b < 4; ++b) {
            for (int c = 0; c < 3; ++c) {
                const Complex exact = test::exact_pole(box, {a, b, c});
                if (a + b + c == 0 || exact.imag() > 0.8 * waves.modes().highest_wave_number)
                    continue;
                const auto nearest =
                    std::min_element(poles.begin(), poles.end(), [&](const auto& x, const auto& y) {
                        return std::abs(x.pole - exact) < std::abs(y.pole - exact);
                    });
                CAPTURE(a, b, c);
                CHECK(nearest->pole.imag() == Approx(exact.imag()).epsilon(3e-3));
                CHECK(nearest->pole.real() == Approx(exact.real()).epsilon(5e-2));
                ++compared;
            }
        }
    }
    CHECK(compared > 25);
}

TEST_CASE("wave_response: the gradient is that of the pressure, in turned rooms as well") {
    const Vec3 size(5, 4, 3);
    Scene scene = box_scene(size, {.1F, .1F, .1F, .1F, .1F, .1F});
    const glm::mat3 rotation = Pose{Vec3(0), 0.4F, 0, 0}.rotation();
    for (Vec3& v : scene.objects[0].vertices) v = rotation * v;
    const RoomWaves waves = waves_of(scene, rotation * (size * 0.3F), 80);
    const Vec3 source = rotation * Vec3(1.2F, 1.1F, 1.5F);
    const Vec3 receiver = rotation * Vec3(3.4F, 2.3F, 1.1F);
    const double k = wave_number_of(90);
    const WaveField field = waves.response(source, receiver).value().reverberant(k);
    constexpr float kStep_m = 0.02F;
    for (int axis = 0; axis < 3; ++axis) {
        Vec3 step(0);
        step[axis] = kStep_m;
        const Complex difference =
            (waves.response(source, receiver + step).value().reverberant(k)[0] -
             waves.response(source, receiver - step).value().reverberant(k)[0]) /
            (2 * double{kStep_m});
        CHECK(std::abs(difference - field[static_cast<std::size_t>(axis) + 1]) <
              0.01 * k * std::abs(field[0]));
    }
}

TEST_CASE("wave_response: source and receiver are interchangeable") {
    Object room = test::l_shaped_room();
    Scene scene = test::grey_room(room, 0.2F, 0.1F, Vec3(1), Vec3(2));
    const RoomWaves waves = waves_of(scene, Vec3(1), 80);
    const WaveResponse there = waves.response({1.1F, 0.8F, 1.4F}, {1.7F, 4.9F, 2.1F}).value();
    const WaveResponse back = waves.response({1.7F, 4.9F, 2.1F}, {1.1F, 0.8F, 1.4F}).value();
    for (const double hz : {30.0, 63.0, 100.0}) {
        const Complex a = there.reverberant(wave_number_of(hz))[0];
        const Complex b = back.reverberant(wave_number_of(hz))[0];
        CHECK(std::abs(a - b) < 1e-6 * std::abs(a));
    }
}

TEST_CASE("wave_response: each octave is that of a room with its coefficients at all frequencies") {
    const Bands absorption = GENERATE(Bands{.1F, .8F, .1F}, Bands{.7F, .2F, .9F});
    const Vec3 size(5, 4, 3);
    const Vec3 source(1.2F, 1.1F, 1.5F);
    const std::vector<Vec3> receivers = places_in(size, source, 8);
    Scene scene = test::grey_room(test::box(size), 0, 0, source, receivers[0]);
    scene.materials[0].absorption = absorption;
    const RoomWaves all = waves_of(scene, source, 260);
    for (std::size_t band = 0; band < 3; ++band) {
        scene.materials[0].absorption = Bands::filled(absorption[band]);
        const RoomWaves own = waves_of(scene, source, 260);
        const double octave_hz{kBandCentres_hz[band]};
        const double end_hz =
            std::min(octave_hz * std::numbers::sqrt2, (1 - kModeTaper) * own.highest_hz());
        for (const Vec3& receiver : receivers) {
            const WaveResponse a = all.response(source, receiver).value();
            const WaveResponse b = own.response(source, receiver).value();
            double sum = 0;
            double expected = 0;
            for (double hz = octave_hz / std::numbers::sqrt2; hz < end_hz; hz += 0.25) {
                sum += std::norm(pressure(a, wave_number_of(hz)));
                expected += std::norm(pressure(b, wave_number_of(hz)));
            }
            CAPTURE(octave_hz, receiver.x, receiver.y, receiver.z);
            CHECK(std::abs(db(sum / expected)) < 0.5);
        }
        // Without a step at the edge.
        const WaveResponse a = all.response(source, receivers[0]).value();
        const double k = wave_number_of(octave_hz * std::numbers::sqrt2);
        if (k > all.modes().highest_wave_number) continue;
        CHECK(std::abs(pressure(a, k * (1 + 1e-6)) - pressure(a, k * (1 - 1e-6))) <
              1e-3 * std::abs(pressure(a, k)));
    }
}

TEST_CASE("wave_response: at the source the field is finite, and that at the nearest distance") {
    const Scene scene = box_scene({5, 4, 3}, {.1F, .1F, .1F, .1F, .1F, .1F});
    const Vec3 source(1.2F, 1.1F, 1.5F);
    const RoomWaves waves = waves_of(scene, source, 80);
    const WaveResponse near = waves.response(source, source + Vec3(0.1F, 0, 0)).value();
    for (const float apart_m : {0.0F, 1e-6F, 0.02F}) {
        const WaveResponse response = waves.response(source, source + Vec3(apart_m, 0, 0)).value();
        for (const double hz : {30.0, 63.0, 100.0}) {
            CAPTURE(apart_m, hz);
            const double k = wave_number_of(hz);
            CHECK(std::abs(pressure(response, k) - pressure(near, k)) < 1);  // of about 10
            for (const Complex& x : response.reverberant(k)) CHECK(std::isfinite(std::abs(x)));
        }
    }
}

TEST_CASE("wave_response: a room twice as large has half the pressure at half the frequency") {
    const auto pressures = [](float scale) {
        Object room = test::l_shaped_room();
        for (Vec3& v : room.vertices) v *= scale;
        const RoomWaves waves = waves_of(
            test::grey_room(room, 0.2F, 0.1F, Vec3(scale), Vec3(2 * scale)), Vec3(scale), 80);
        const WaveResponse response =
            waves.response(scale * Vec3(1.1F, 0.8F, 1.4F), scale * Vec3(1.7F, 4.9F, 2.1F)).value();
        std::vector<Complex> result;
        for (double hz = 20; hz < 80; hz += 5) {
            const double k = wave_number_of(hz) / double{scale};
            result.push_back(pressure(response, k) * double{scale});
        }
        return result;
    };
    const std::vector<Complex> once = pressures(1);
    const std::vector<Complex> twice = pressures(2);
    for (std::size_t i = 0; i < once.size(); ++i) {
        // The iteration ends within 1e-4 of a frequency.
        CHECK(std::abs(once[i] - twice[i]) < 5e-3 * std::abs(once[i]));
    }
}

TEST_CASE("wave_response: the walls absorb the power that the source radiates") {
    // At a resonance: the source's power is that of the field at its place, Im(p) k / (8 pi rho c)
    // up to a factor that the walls share: the integral of the admittance times |p|^2 over them.
    const Vec3 size(4, 3, 2.5F);
    const std::array<float, 6> absorption{.1F, .1F, .2F, .1F, .3F, .1F};
    const RoomWaves waves = waves_of(box_scene(size, absorption), size * 0.3F, 120);
    const Vec3 source(1, 0.9F, 1.2F);
    const test::DampedBox box = damped_box(size, absorption);
    for (const double hz : {45.0, 70.0, 90.0}) {
        const double k = wave_number_of(hz);
        const double radiated =
            -waves.response(source, source).value().modal(k)[0].imag() * 4 * std::numbers::pi;
        double absorbed = 0;
        constexpr int kParts = 12;
        for (int wall = 0; wall < 6; ++wall) {
            const int axis = wall / 2;
            const int b = (axis + 1) % 3;
            const int c = (axis + 2) % 3;
            const float area_m2 = size[b] * size[c] / (kParts * kParts);
            for (int i = 0; i < kParts * kParts; ++i) {
                Vec3 at(0);
                at[axis] = wall % 2 == 0 ? 1e-3F : size[axis] - 1e-3F;
                at[b] = size[b] * (static_cast<float>(i % kParts) + 0.5F) / kParts;
                at[c] = size[c] * (static_cast<float>(i / kParts) + 0.5F) / kParts;
                absorbed += k *
                            box.admittance[static_cast<std::size_t>(axis)]
                                          [static_cast<std::size_t>(wall % 2)] *
                            double{area_m2} *
                            std::norm(waves.response(source, at).value().modal(k)[0]);
            }
        }
        CHECK(absorbed == Approx(radiated).epsilon(0.03));
    }
}

TEST_CASE("wave_response: an L-shaped corridor and a door agree with a finer grid") {
    Object room;
    Vec3 source(0);
    std::vector<Vec3> receivers;
    double modes = 110;
    std::vector<double> octaves{63, 125};
    SECTION("corridor") {
        modes = 240;
        octaves.push_back(250);
        room = test::l_shaped_room();
        for (Vec3& v : room.vertices) v *= Vec3(0.67F, 0.67F, 0.87F);  // 2 m wide
        source = {3.4F, 0.8F, 1.3F};
        receivers = {{0.9F, 3.5F, 1.2F}, {1.3F, 2.9F, 1.7F}, {0.5F, 2.5F, 0.9F}};
    }
    SECTION("a door of 0.9 m x 2 m in a thin wall") {
        room = test::box({6, 4, 2.6F});
        // The wall x = 3 beside and above the door, y from 1.5 to 2.4.
        const auto add = [&](float y0, float y1, float z0, float z1) {
            const auto first = static_cast<std::uint32_t>(room.vertices.size());
            for (const Vec3 v :
                 {Vec3(3, y0, z0), Vec3(3, y1, z0), Vec3(3, y1, z1), Vec3(3, y0, z1)})
                room.vertices.push_back(v);
            room.triangles.push_back({first, first + 1, first + 2});
            room.triangles.push_back({first, first + 2, first + 3});
            room.triangle_materials.insert(room.triangle_materials.end(), 2, 0);
        };
        add(0, 1.5F, 0, 2.6F);
        add(2.4F, 4, 0, 2.6F);
        add(1.5F, 2.4F, 2, 2.6F);
        source = {1.2F, 1.1F, 1.5F};
        receivers = {{4.9F, 0.9F, 1.2F}, {4.1F, 2.9F, 1.7F}, {5.5F, 2.5F, 0.9F}};
    }
    const Scene scene = test::grey_room(room, 0.1F, 0.1F, source, receivers[0]);
    const RoomWaves coarse = waves_of(scene, source, modes);
    const RoomWaves fine = waves_of(scene, source, modes, 1.8);
    CHECK(fine.grid().cells().cells() > 4 * coarse.grid().cells().cells());
    REQUIRE(fine.highest_hz() > octaves.back() * std::numbers::sqrt2);
    for (const Vec3& receiver : receivers) {
        const WaveResponse a = coarse.response(source, receiver).value();
        const WaveResponse b = fine.response(source, receiver).value();
        for (const double octave : octaves) {
            double sum = 0;
            double finer = 0;
            for (double hz = octave / std::sqrt(2.0); hz < octave * std::sqrt(2.0); hz += 0.5) {
                sum += std::norm(pressure(a, wave_number_of(hz)));
                finer += std::norm(pressure(b, wave_number_of(hz)));
            }
            CAPTURE(octave);
            CHECK(std::abs(db(sum / finer)) < 0.5);
        }
    }
}

TEST_CASE("room_waves: a thin wall separates the air on its two sides") {
    // Two rooms, and a wall without thickness between them in the plane x = 2.5.
    Object rooms = test::box({5, 4, 3});
    const auto first = static_cast<std::uint32_t>(rooms.vertices.size());
    for (const Vec3 v : {Vec3(2.5F, 0, 0), Vec3(2.5F, 4, 0), Vec3(2.5F, 4, 3), Vec3(2.5F, 0, 3)})
        rooms.vertices.push_back(v);
    rooms.triangles.push_back({first, first + 1, first + 2});
    rooms.triangles.push_back({first, first + 2, first + 3});
    rooms.triangle_materials.insert(rooms.triangle_materials.end(), 2, 0);
    const Vec3 source(1, 1.2F, 1.5F);
    // The wall also lies within cells: turned about an axis of the grid it is in none of its
    // planes.
    for (const float turn_m : {0.0F, 0.4F}) {
        rooms.vertices[first].x = rooms.vertices[first + 3].x = 2.5F + turn_m;
        const Scene scene = test::grey_room(rooms, 0.1F, 0.1F, source, Vec3(2));
        const RoomWaves waves = waves_of(scene, source, 60);
        for (float y = 0.3F; y < 4; y += 0.23F) {
            const float wall_x = 2.5F + turn_m * (1 - y / 4);
            CAPTURE(turn_m, y);
            CHECK(waves.response(source, {wall_x - 0.02F, y, 1.4F}));
            CHECK_FALSE(waves.response(source, {wall_x + 0.02F, y, 1.4F}));
        }
    }
}

TEST_CASE("room_waves: after a small change a search is short and finds the same modes") {
    const Vec3 source(1, 1.2F, 1.5F);
    const auto rooms_with_door = [&](float open_m) {
        Object rooms = test::box({5, 4, 3});
        const auto first = static_cast<std::uint32_t>(rooms.vertices.size());
        for (const Vec3 v :
             {Vec3(2.4F, open_m, 0), Vec3(2.4F, 4, 0), Vec3(2.4F, 4, 3), Vec3(2.4F, open_m, 3)})
            rooms.vertices.push_back(v);
        rooms.triangles.push_back({first, first + 1, first + 2});
        rooms.triangles.push_back({first, first + 2, first + 3});
        rooms.triangle_materials.insert(rooms.triangle_materials.end(), 2, 0);
        return std::make_shared<const RayScene>(
            test::grey_room(rooms, 0.1F, 0.1F, source, Vec3(2)));
    };
    WorkerPool pool(1);
    const std::vector<Vec3> places{source};
    const WaveLimits limits{.modes = 100, .highest_hz = 1e4, .schroeder = 1e4};
    const auto wide = RoomWaves::find(rooms_with_door(1.1F), places, kSpeed_m_s, limits, pool);
    // The last one is shut.
    for (const float open_m : {0.8F, 0.3F, 0.0F}) {
        CAPTURE(open_m);
        const auto narrow = rooms_with_door(open_m);
        const auto cold = RoomWaves::find(narrow, places, kSpeed_m_s, limits, pool);
        const auto warm = RoomWaves::find(narrow, places, kSpeed_m_s, limits, pool, &wide.value());
        if (open_m > 0.5F) CHECK(warm->modes().passes < cold->modes().passes);
        REQUIRE(warm->modes().count() == cold->modes().count());
        double change = 0;
        for (std::size_t m = 1; m < cold->modes().count(); ++m) {
            const double k2 = cold->modes().wave_number2[m];
            CHECK(warm->modes().wave_number2[m] == Approx(k2).epsilon(2e-3));
            if (m < wide->modes().count())
                change = std::max(change, std::abs(wide->modes().wave_number2[m] / k2 - 1));
        }
        CHECK(change > 0.1);
    }
}

TEST_CASE("room_waves: a body of a single cell has no modes") {
    const Vec3 size(0.05F);
    const Scene scene = test::grey_room(test::box(size), 0.1F, 0.1F, size * 0.3F, size * 0.6F);
    WorkerPool pool(1);
    const std::vector<Vec3> places{size * 0.3F};
    CHECK_FALSE(
        RoomWaves::find(std::make_shared<const RayScene>(scene), places, kSpeed_m_s, {}, pool));
}

TEST_CASE("room_waves: limits lower the highest frequency, an open room has no modes") {
    Scene scene = box_scene({5, 4, 3}, {.1F, .1F, .1F, .1F, .1F, .1F});
    const std::vector<Vec3> places{Vec3(1)};
    WorkerPool pool(1);
    const auto highest_hz = [&](const WaveLimits& limits) {
        const auto waves = RoomWaves::find(std::make_shared<const RayScene>(scene), places,
                                           kSpeed_m_s, limits, pool);
        return waves ? waves->highest_hz() : 0;
    };
    CHECK(highest_hz({.highest_hz = 80}) == Approx(80));
    // Eyring: T = 0.161 * 60 / (94 * 0.1054) s, 2000 sqrt(T / V) = 255 Hz.
    CHECK(highest_hz({.modes = 60, .schroeder = 0.5}) == Approx(127.5).epsilon(0.01));
    const double few_hz = highest_hz({.most_cells = 600});
    CHECK(few_hz > 60);
    CHECK(few_hz < 130);
    scene.objects[0].triangles.resize(10);
    scene.objects[0].triangle_materials.resize(10);
    CHECK(highest_hz({}) == 0);
    CHECK_FALSE(
        RoomWaves::find(std::make_shared<const RayScene>(Scene()), places, kSpeed_m_s, {}, pool));
}

TEST_CASE("wall_admittance: absorption in a diffuse field by Paris") {
    CHECK(absorption_of_admittance(1) == Approx(0.909).margin(1e-3));
    for (const double alpha : {0.01, 0.1, 0.5, 0.9, 0.95}) {
        CHECK(absorption_of_admittance(admittance_of_absorption(alpha)) == Approx(alpha));
    }
    CHECK(admittance_of_absorption(1) == admittance_of_absorption(0.99));
    CHECK(admittance_of_absorption(1) == Approx(0.64).margin(0.03));
    CHECK(admittance_of_absorption(0) == Approx(0).margin(1e-9));
}

TEST_CASE("wave_response: the direct sound beyond a wave number") {
    CHECK(sine_cosine_integrals(1)[0] == Approx(0.946083));
    CHECK(sine_cosine_integrals(1)[1] == Approx(0.337404));
    CHECK(sine_cosine_integrals(5)[0] == Approx(1.549931));
    CHECK(sine_cosine_integrals(5)[1] == Approx(-0.190030));
    // Of an integral that was computed numerically up to 200 / m, and the remainder of a sine.
    const double r = 1.3;
    const double k = 2;
    double sum = 0;
    constexpr double kStep = 1e-3;
    const double taper = kModeTaper * 4.5;
    for (double at = 4.5 - taper + kStep / 2; at < 200; at += kStep) {
        const double share = std::min((at - 4.5 + taper) / taper, 1.0);
        sum +=
            share * 2 / (std::numbers::pi * r) * at * std::sin(at * r) / (at * at - k * k) * kStep;
    }
    sum += 2 / (std::numbers::pi * r) * std::cos(200 * r) / (200 * r);
    const auto [value, slope] = direct_field_beyond(r, k, 4.5);
    CHECK(value == Approx(sum).margin(1e-3));
    CHECK(slope == Approx((direct_field_beyond(r + 1e-4, k, 4.5)[0] -
                           direct_field_beyond(r - 1e-4, k, 4.5)[0]) /
                          2e-4)
                       .margin(1e-4));
}

TEST_CASE("wave_response: spectra are the field at each wave number") {
    RandomStream random(3);
    WaveResponse response;
    const double edge = wave_number_of(88);
    for (const auto& [begin, end] : {std::pair(0.0, edge), std::pair(edge, double{INFINITY})}) {
        WaveResponse::Octaves& octaves = response.octaves.emplace_back();
        octaves.begin = begin;
        octaves.end = end;
        for (int i = 0; i < 50; ++i) {
            // One real pole.
            const double wave_number = i == 0 ? 0 : 4 * double{random.uniform()};
            octaves.poles.emplace_back(-0.005 - 0.02 * double{random.uniform()}, wave_number);
            WaveField& residue = octaves.residues.emplace_back();
            for (Complex& c : residue)
                c = {double{random.uniform()} - 0.5, i == 0 ? 0 : double{random.uniform()} - 0.5};
        }
    }
    const double step = wave_number_of(0.3);
    constexpr std::size_t kCount = 700;
    const WaveSpectra spectra = response.modal(step, kCount, 0);
    double error = 0;
    double power = 0;
    for (std::size_t k = 1; k < kCount; ++k) {
        const WaveField field = response.modal(static_cast<double>(k) * step);
        for (std::size_t c = 0; c < 4; ++c) {
            error += std::norm(spectra[c][k] - field[c]);
            power += std::norm(field[c]);
        }
    }
    CHECK(spectra[0][0] == 0.0);
    CHECK(std::sqrt(error / power) < 3e-4);
}

TEST_CASE("wave_response: the amplitudes of modes give the pressure at each place") {
    const Scene scene = box_scene({5, 4, 3}, {0.1F, 0.6F, 0.2F, 0.1F, 0.3F, 0.1F});
    const Vec3 source(1, 1.2F, 0.8F);
    const RoomWaves waves = waves_of(scene, source, 60);
    for (const double hz : {30.0, 63.0, 90.0}) {
        const std::vector<Complex> amplitudes = waves.amplitudes(source, hz);
        for (const Vec3& place : {Vec3(2.5F, 2, 1.5F), Vec3(4.5F, 0.3F, 2.8F)}) {
            const auto response = waves.response(source, place);
            const auto modes = waves.modes_at(place);
            REQUIRE(response);
            REQUIRE(modes);
            Complex sum = 0;
            for (std::size_t m = 0; m < amplitudes.size(); ++m)
                sum += amplitudes[m] * modes->pressure[m];
            CHECK(std::abs(sum - response->modal(waves.wave_number_of(hz))[0]) <
                  1e-6 * std::abs(sum));
        }
    }
    CHECK(waves.amplitudes({-1, 0, 0}, 63).empty());
}

}  // namespace wave_response_test
