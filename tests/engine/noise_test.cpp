// Noise of the estimators relative to plain path tracing. Prints one line for each estimator.

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <vector>

#include "aula/engine/propagation.h"
#include "engine/base/sampling.h"
#include "tests/support/measure.h"
#include "tests/support/rooms.h"
#include "tests/support/statistics.h"

using namespace aula;

namespace {

constexpr int kRestarts = 64;
constexpr std::size_t kFirstBin = 5;  // of 10 ms: 50 ms
constexpr std::size_t kEndBin = 50;   // 500 ms

/// Energy of all bands in bins of 10 ms.
std::vector<double> bins_of_10_ms(const EnergyResponse& response) {
    std::vector<double> energies;
    for (const Bands& e : response.uniform(0.01)) energies.push_back(double{e.sum()});
    return energies;
}

struct Noise {
    double relative_deviation = 0;       // mean over bins of standard deviation / mean
    std::vector<test::Estimate> groups;  // energy in groups of 50 ms
};

Noise measure(const Scene& scene, Estimator estimator, int restarts, float radius_m) {
    Simulation simulation = scene.simulation;
    simulation.estimator = estimator;
    simulation.listener_radius_m = radius_m;
    Propagation propagation(scene, simulation);
    const int frames = estimator == Estimator::pt ? 1 : simulation.window_frames();
    std::vector<std::vector<double>> bins(kEndBin);
    std::vector<std::vector<double>> groups((kEndBin - kFirstBin) / 5);
    test::restarts(propagation, scene, restarts, frames, [&](const EnergyResponse& response) {
        const std::vector<double> energies = bins_of_10_ms(response);
        for (std::size_t k = kFirstBin; k < kEndBin; ++k) bins[k].push_back(energies[k]);
        for (std::size_t g = 0; g < groups.size(); ++g) {
            double sum = 0;
            for (std::size_t k = 0; k < 5; ++k) sum += energies[kFirstBin + 5 * g + k];
            groups[g].push_back(sum);
        }
        return 0.0;
    });
    Noise noise;
    for (std::size_t k = kFirstBin; k < kEndBin; ++k) {
        const test::Estimate e = test::estimate(bins[k]);
        noise.relative_deviation += e.standard_error * std::sqrt(static_cast<double>(restarts)) /
                                    e.mean / (kEndBin - kFirstBin);
    }
    for (const auto& samples : groups) noise.groups.push_back(test::estimate(samples));
    return noise;
}

/// Mean over groups of the ratio of the energy to a reference, with its standard error.
test::Estimate ratio(const Noise& noise, const Noise& reference) {
    test::Estimate e;
    double variance = 0;
    const auto n = static_cast<double>(noise.groups.size());
    for (std::size_t g = 0; g < noise.groups.size(); ++g) {
        const test::Estimate& a = noise.groups[g];
        const test::Estimate& b = reference.groups[g];
        e.mean += a.mean / b.mean / n;
        variance += std::pow(a.standard_error / a.mean, 2) + std::pow(b.standard_error / b.mean, 2);
    }
    // Neighbouring groups hold the same rays: their errors count as fully correlated.
    e.standard_error = std::sqrt(variance / n);
    return e;
}

/// The mean over bins of sqrt(1 + v^2), v the relative spread of the arrivals' energies. Squared
/// energies decay as in a room whose walls reflect the square of their share, the number of
/// arrivals as in a lossless room.
double mean_spread(const Scene& scene) {
    const double reflected = 1 - double{scene.materials[0].absorption[0]};
    const auto response = [&](double share) {
        Scene other = scene;
        other.materials[0].absorption = Bands::filled(static_cast<float>(1 - share));
        Propagation propagation(other, test::with(other, Estimator::patch, 0.55F, 0.5F));
        for (int f = 0; f < 10; ++f) propagation.step(test::static_input(other));
        return bins_of_10_ms(propagation.response(0));
    };
    const std::vector<double> number = response(1);
    const std::vector<double> energy = response(reflected);
    const std::vector<double> square = response(reflected * reflected);
    double sum = 0;
    for (std::size_t k = kFirstBin; k < kEndBin; ++k) {
        sum += std::sqrt(square[k] * number[k]) / energy[k];
    }
    return sum / (kEndBin - kFirstBin);
}

/// <w^2> / <w>^2 over the walls of a box, w = cos / d^2 of the view from a point.
double spread_of_view(const Vec3& size, const Vec3& point) {
    constexpr int kSteps = 400;
    double area = 0;
    double sum = 0;
    double squares = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const int u = (axis + 1) % 3;
        const int v = (axis + 2) % 3;
        const double step_m2 = double{size[u]} * double{size[v]} / (kSteps * kSteps);
        for (const double distance_m : {double{point[axis]}, double{size[axis] - point[axis]}}) {
            for (int i = 0; i < kSteps * kSteps; ++i) {
                const double x = (i % kSteps + 0.5) / kSteps * double{size[u]} - double{point[u]};
                const double y = (i / kSteps + 0.5) / kSteps * double{size[v]} - double{point[v]};
                const double w =
                    distance_m / std::pow(distance_m * distance_m + x * x + y * y, 1.5);
                area += step_m2;
                sum += w * step_m2;
                squares += w * w * step_m2;
            }
        }
    }
    return squares * area / (sum * sum);
}

}  // namespace

TEST_CASE("at equal rays the caches have less noise than path tracing, and no bias") {
    Scene scene =
        test::grey_room(test::box(Vec3(10, 8, 4)), 0.2F, 1, Vec3(3, 3, 1.5F), Vec3(5, 4, 2));
    scene.simulation.ir_length_s = 0.55F;
    scene.simulation.response_time_s = 0.5F;  // F = 15
    scene.simulation.rays = 1000;
    scene.simulation.order = 50;

    const Noise reference = measure(scene, Estimator::pt, 1500, 0.5F);
    const Noise plain = measure(scene, Estimator::pt, kRestarts, 0.5F);
    const Noise published = measure(scene, Estimator::dpc_published, kRestarts, 0.5F);
    const Noise dpc = measure(scene, Estimator::dpc, kRestarts, 0.5F);
    const Noise patch = measure(scene, Estimator::patch, kRestarts, 0.5F);
    for (const auto& [name, noise] :
         {std::pair("pt", &plain), std::pair("dpc-published", &published), std::pair("dpc", &dpc),
          std::pair("patch", &patch)}) {
        const test::Estimate r = ratio(*noise, reference);
        std::printf("noise %-13s %.4f  energy ratio %.4f +- %.4f\n", name,
                    noise->relative_deviation, r.mean, r.standard_error);
    }

    // The law of independent rays: of k expected arrivals, chords across a sphere, a bin's relative
    // variance is (9/8) (1 + v^2) / k. Rays cross the sphere c pi R^2 / V times a second. Uniform
    // initial directions reduce it by at most the spread v of the energies; 4 % are three standard
    // errors.
    const double k = 1000 * 343.2 * std::numbers::pi * 0.25 / 320 * 0.01;
    const double min = std::sqrt(9.0 / 8 / k);
    const double max = min * mean_spread(scene);
    std::printf("noise pt by the law of variance: %.4f to %.4f\n", min, max);
    CHECK(plain.relative_deviation > 0.96 * min);
    CHECK(plain.relative_deviation < 1.04 * max);
    CHECK(plain.relative_deviation / std::sqrt(2.0) < 0.96 * min);  // companion: twice the rays
    CHECK(plain.relative_deviation * std::sqrt(2.0) > 1.04 * max);  // and half of them

    // The path cache holds the rays of all frames of its window.
    const double frames = scene.simulation.window_frames();
    CHECK(dpc.relative_deviation < 1.04 * max / std::sqrt(frames));
    CHECK(dpc.relative_deviation * std::sqrt(2.0) > 1.04 * max / std::sqrt(frames));

    // The patches count each reflection in the room: a ray has one in each mean free path 4 V / S.
    // Reflections at random places x of the walls count as w = cos / |x - listener|^2, so that of k
    // of them a bin's relative variance is (<w^2> / <w>^2) (1 + v^2) / k.
    const double reflections = 1000 * frames * 343.2 * 0.01 / (4 * 320.0 / 304);
    const double law =
        std::sqrt(spread_of_view(Vec3(10, 8, 4), Vec3(5, 4, 2)) / reflections) * mean_spread(scene);
    std::printf("noise patch by the law of variance: at most %.4f\n", law);
    CHECK(patch.relative_deviation < 1.04 * law);
    CHECK(patch.relative_deviation * std::sqrt(2.0) > 1.04 * law);

    for (const Noise* noise : {&dpc, &patch}) {
        const test::Estimate r = ratio(*noise, reference);
        CHECK(std::abs(r.z(1)) < 3);
        CHECK(r.standard_error < 0.02);
    }
    CHECK(ratio(published, reference).z(1) > test::kRefutedZ);  // companion: Eq. 3.2 is biased
}
