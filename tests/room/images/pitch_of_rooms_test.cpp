#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include "aula/measurement.h"
#include "tests/support/rooms.h"

// What gives small rooms and corridors a pitch, compared with exact image sources.

namespace pitch_of_rooms_test {

using namespace aula;

namespace {

constexpr double kRate_hz = 16000;
const Vec3 kSource(0.5F, 0.6F, 1.2F);
const Vec3 kListener(1.4F, 1.5F, 1.6F);

std::vector<float> mono_response(const Scene& scene, int frames) {
    const auto measured = measure(scene, MeasurementOptions{.frames = frames, .parameters = false});
    OutputOptions options;
    options.sample_rate_hz = kRate_hz;
    options.output = OutputFormat::mono;
    return ImpulseResponses(*measured, options).response(0, 0)[0];
}

double correlation(const std::vector<double>& a, const std::vector<double>& b) {
    double sum_a = 0, sum_b = 0, aa = 0, bb = 0, ab = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        sum_a += a[i];
        sum_b += b[i];
        aa += a[i] * a[i];
        bb += b[i] * b[i];
        ab += a[i] * b[i];
    }
    const auto n = static_cast<double>(a.size());
    return (n * ab - sum_a * sum_b) /
           std::sqrt((n * aa - sum_a * sum_a) * (n * bb - sum_b * sum_b));
}

double level_db(std::complex<double> pressure) { return 10 * std::log10(std::norm(pressure)); }

/// Levels of a response at frequencies.
std::vector<double> levels_of(const std::vector<float>& response, double first_hz, double step_hz,
                              std::size_t count) {
    std::vector<double> levels;
    for (std::size_t i = 0; i < count; ++i) {
        const double hz = first_hz + step_hz * static_cast<double>(i);
        const auto turn = std::polar(1.0, -2 * std::numbers::pi * hz / kRate_hz);
        std::complex<double> sum = 0, phase = 1;
        for (const float x : response) {
            sum += double{x} * phase;
            phase *= turn;
        }
        levels.push_back(level_db(sum));
    }
    return levels;
}

/// The same of all image sources of a box of equal walls, up to a distance.
std::vector<double> exact_levels(const Vec3& size, double absorption, double reach_m,
                                 double speed_m_s, double first_hz, double step_hz,
                                 std::size_t count) {
    std::vector<std::complex<double>> sums(count);
    const auto along = [&](int axis, int n) {
        const double length{size[axis]};
        const double at{kSource[axis]};
        return (n % 2 == 0 ? n * length + at : (n + 1) * length - at) - double{kListener[axis]};
    };
    const int most = static_cast<int>(reach_m / 2) + 2;
    for (int i = -most; i <= most; ++i)
        for (int j = -most; j <= most; ++j)
            for (int k = -most; k <= most; ++k) {
                const double d = std::hypot(along(0, i), along(1, j), along(2, k));
                if (d >= reach_m) continue;
                const double amplitude =
                    std::pow(1 - absorption, 0.5 * (std::abs(i) + std::abs(j) + std::abs(k))) / d;
                const double per_hz = -2 * std::numbers::pi * d / speed_m_s;
                const auto turn = std::polar(1.0, per_hz * step_hz);
                std::complex<double> phase = std::polar(amplitude, per_hz * first_hz);
                for (std::complex<double>& sum : sums) {
                    sum += phase;
                    phase *= turn;
                }
            }
    std::vector<double> levels;
    for (const std::complex<double>& sum : sums) levels.push_back(level_db(sum));
    return levels;
}

/// The autocorrelation at a lag near `lag_s` of 0.1 s of a response.
double repetition(const std::vector<float>& response, double from_s, double lag_s) {
    const auto first = static_cast<std::size_t>(from_s * kRate_hz);
    const auto count = static_cast<std::size_t>(0.1 * kRate_hz);
    const auto middle = static_cast<std::size_t>(lag_s * kRate_hz);
    double best = 0;
    for (std::size_t lag = middle - 4; lag <= middle + 4; ++lag) {
        double own = 0, other = 0, both = 0;
        for (std::size_t n = first; n < first + count; ++n) {
            own += double{response[n]} * double{response[n]};
            other += double{response[n + lag]} * double{response[n + lag]};
            both += double{response[n]} * double{response[n + lag]};
        }
        best = std::max(best, both / std::sqrt(own * other));
    }
    return best;
}

}  // namespace

TEST_CASE("Measured small boxes have the spectra of their image sources, with modes below") {
    struct Room {
        Vec3 size;
        float absorption;
        float length_s;
        double least;  ///< correlation from 20 to 300 Hz
    };
    // In the corridor, walls whose admittance has the absorption in a diffuse field damp modes
    // along it more than image sources do.
    for (const Room& room : {Room{{2, 2, 2.5F}, 0.2F, 0.25F, 0.99},
                             {{4, 3, 2.5F}, 0.2F, 0.35F, 0.95},
                             {{6, 5.5F, 3}, 0.3F, 0.35F, 0.95},
                             {{20, 2, 2.5F}, 0.3F, 0.25F, 0.95}}) {
        Scene scene = test::grey_room(test::box(room.size), room.absorption, 0, kSource, kListener);
        scene.simulation = {};
        scene.simulation.ir_length_s = room.length_s;
        scene.simulation.threads = 1;
        const std::vector<float> response = mono_response(scene, 1);
        const double speed_m_s = double{scene.medium.speed_of_sound_m_s()};
        const auto correlation_from = [&](const std::vector<float>& of, double first_hz,
                                          double step_hz, std::size_t count) {
            return correlation(
                levels_of(of, first_hz, step_hz, count),
                exact_levels(room.size, double{room.absorption}, double{room.length_s} * speed_m_s,
                             speed_m_s, first_hz, step_hz, count));
        };
        CAPTURE(room.size.x, room.size.y, room.size.z);
        CHECK(correlation_from(response, 20, 4, 70) > room.least);
        CHECK(correlation_from(response, 300, 17, 100) > 0.98);
        // Companion: with the least scattering there are no image sources of all orders.
        scene.materials[0].scattering = Bands::filled(1e-6F);
        CHECK(correlation_from(mono_response(scene, 2), 300, 17, 100) < 0.6);
    }
}

TEST_CASE("A flutter echo between hard walls repeats as that of its image sources") {
    // The pitch of a corridor of 2.5 m, whose other walls are soft. Turned, it is no box of image
    // sources.
    const Vec3 size(12, 2.5F, 3);
    const Vec3 source(4, 1, 1.3F);
    const Vec3 listener(6, 1.6F, 1.7F);
    const auto response_of = [&](bool is_turned, int specular_order) {
        const auto placed = [&](const Vec3& p) {
            return is_turned ? Vec3(0.8F * p.x - 0.6F * p.y, 0.6F * p.x + 0.8F * p.y, p.z) : p;
        };
        Scene scene = test::grey_room(test::box(size), 0.97F, 0, placed(source), placed(listener));
        scene.simulation = {};
        scene.simulation.waves_hz = 0;
        scene.simulation.specular_order = specular_order;
        scene.simulation.ir_length_s = 0.5F;
        scene.simulation.threads = 1;
        scene.materials.push_back(scene.materials[0]);
        scene.materials[1].absorption = Bands::filled(0.03F);
        test::set_walls_across_y(scene.objects[0], 1);
        for (Vec3& vertex : scene.objects[0].vertices) vertex = placed(vertex);
        return mono_response(scene, 4);
    };
    const std::vector<float> exact = response_of(false, 3);
    const std::vector<float> flutter = response_of(true, 3);
    const std::vector<float> rays = response_of(true, 0);
    for (const double from_s : {0.05, 0.1, 0.2, 0.3}) {
        const double expected = repetition(exact, from_s, 5.0 / 343.2);
        CAPTURE(from_s, expected);
        CHECK(repetition(flutter, from_s, 5.0 / 343.2) == Approx(expected).epsilon(0.2));
        CHECK(repetition(rays, from_s, 5.0 / 343.2) < 0.2);  // companion: bursts of noise
    }
    CHECK(repetition(exact, 0.2, 5.0 / 343.2) > 0.6);
}

}  // namespace pitch_of_rooms_test
