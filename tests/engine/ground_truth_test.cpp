// Rooms with an exact solution. rho = 1 - alpha, P = 1, all walls Lambert, no air.

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <vector>

#include "aula/engine/propagation.h"
#include "engine/base/sampling.h"
#include "engine/trace/arrival_tracer.h"
#include "tests/support/measure.h"
#include "tests/support/rooms.h"
#include "tests/support/statistics.h"

using namespace aula;

namespace {

constexpr double kPi = std::numbers::pi;

Simulation patch(const Scene& scene, float ir_length_s, int order, float patch_size_m = 0.5F) {
    Simulation simulation = test::with(scene, Estimator::patch, ir_length_s);
    simulation.order = order;
    simulation.patch_size_m = patch_size_m;
    return simulation;
}

double total(const EnergyResponse& response) { return test::total(response); }

/// Rate in 1/s of the decay within a time, over eight seeds.
test::Estimate decay_rate(const Scene& scene, float ir_length_s, double begin_s, double end_s) {
    std::vector<double> rates;
    for (int i = 0; i < 8; ++i) {
        Simulation simulation = patch(scene, ir_length_s, 0);
        simulation.seed = derive_seed(test::test_seed(), i);
        simulation.rays = 1500;
        Propagation propagation(scene, simulation);
        for (int f = 0; f < 25; ++f) propagation.step(test::static_input(scene));
        rates.push_back(test::decay_rate(propagation.response(0), begin_s, end_s, 12));
    }
    return test::estimate(rates);
}

/// Root of 2 rho [1 + (x - 1) e^x] / x^2 = 1 for x = 2 R s / c > 0, by bisection.
double sphere_decay(double rho) {
    double low = 1e-3;
    double high = 10;
    for (int i = 0; i < 100; ++i) {
        const double x = (low + high) / 2;
        (2 * rho * (1 + (x - 1) * std::exp(x)) / (x * x) < 1 ? low : high) = x;
    }
    return low;
}

}  // namespace

TEST_CASE("the sphere's decay constants are those of its equation") {
    CHECK(sphere_decay(0.9) == Approx(0.157021).margin(1e-6));
    CHECK(sphere_decay(0.8) == Approx(0.330239).margin(1e-6));
    CHECK(sphere_decay(0.7) == Approx(0.523852).margin(1e-6));
    CHECK(sphere_decay(0.5) == Approx(1).margin(1e-6));
}

TEST_CASE("orders of a Lambert sphere are rho^n P / (pi R^2) at any place") {
    constexpr float kRadius_m = 3;
    const Object sphere = test::icosphere(kRadius_m, 4);
    // The mesh is slightly smaller than the sphere: the radius with the mesh's surface area.
    const double radius_2 = test::surface_m2(sphere) / (4 * kPi);
    const Scene scene =
        test::grey_room(sphere, 0.3F, 1, Vec3(1.2F, 0.4F, -0.3F), Vec3(-1, -1.1F, 0.5F));
    // The difference of two limits of the order, from the same rays, is one order.
    Propagation two(scene, patch(scene, 0.2F, 2));
    Propagation one(scene, patch(scene, 0.2F, 1));
    Propagation three(scene, patch(scene, 0.2F, 3));
    const auto e1 = test::restarts(one, scene, 16, 15, total);
    const auto e2 = test::restarts(two, scene, 16, 15, total);
    const auto e3 = test::restarts(three, scene, 16, 15, total);
    std::vector<double> second;
    std::vector<double> third;
    for (std::size_t i = 0; i < e1.size(); ++i) {
        second.push_back(e2[i] - e1[i]);
        third.push_back(e3[i] - e2[i]);
    }
    for (const auto& [samples, order] : {std::pair(second, 2), std::pair(third, 3)}) {
        const double exact = std::pow(0.7, order) / (kPi * radius_2);
        const test::Estimate e = test::estimate(samples);
        CAPTURE(order, e.mean, e.standard_error, exact);
        // The mesh's facets: 0.2 %.
        CHECK(std::abs(e.mean - exact) < test::kFamilyZ * e.standard_error + 2e-3 * exact);
        CHECK(std::abs(e.z(1.05 * exact)) > test::kRefutedZ);  // companion
    }
}

TEST_CASE("from a sphere's centre to its centre the lengths have the exact mean and variance") {
    constexpr float kRadius_m = 3;
    const Object sphere = test::icosphere(kRadius_m, 4);
    const double radius_m = std::sqrt(test::surface_m2(sphere) / (4 * kPi));
    const Scene scene = test::grey_room(sphere, 0, 1, Vec3(0), Vec3(0));
    const RayScene rays(scene);
    const PatchSubdivision subdivision(rays, 0.5F);
    const SpecularPaths images(rays, 0, 0.5F, 1);
    TraceSettings settings;
    settings.rays = 400000;
    const auto moments = [&](int order) {
        settings.order = order;
        const ArrivalTracer tracer(rays, subdivision, images, settings);
        std::array<double, 4> m{};
        for (int b = 0; b < tracer.batch_count(); ++b) {
            ArrivalBatch batch;
            const Vec3 centre(0);
            const Receiver receiver{centre, 0.2F};
            tracer.trace({0, centre}, {&receiver, 1}, test::test_seed(), b, batch);
            for (const Arrival& a : batch.arrivals) {
                const double e = double{a.energy[0]};
                const double r = double{a.length_m};
                m[0] += e;
                m[1] += e * r;
                m[2] += e * r * r;
                m[3] += 1;
            }
        }
        return m;
    };
    auto before = moments(1);
    // Order 1 at the centre: all energy returns, exactly.
    CHECK(before[0] / settings.rays == Approx(1 / (kPi * radius_m * radius_m)).epsilon(0.03));
    CHECK(before[1] / before[0] == Approx(2 * radius_m).epsilon(2e-3));
    for (int n = 2; n <= 4; ++n) {
        const auto upto = moments(n);
        const double energy = upto[0] - before[0];
        const double mean = (upto[1] - before[1]) / energy;
        const double variance = (upto[2] - before[2]) / energy - mean * mean;
        const double hits = upto[3] - before[3];
        const double exact_mean = 2 * radius_m + 4 * radius_m * (n - 1) / 3;
        const double exact_variance = 2 * radius_m * radius_m * (n - 1) / 9;
        CAPTURE(n, hits, mean, variance);
        // Weighted by chords: 9/8 of the variance of the mean; four standard errors, and 0.1 % for
        // the sphere of 0.2 m and the facets.
        CHECK(std::abs(mean - exact_mean) <
              4 * std::sqrt(exact_variance * 9 / 8 / hits) + 1e-3 * exact_mean);
        CHECK(variance == Approx(exact_variance).epsilon(4 * std::sqrt(3 / hits) + 0.01));
        before = upto;
    }
}

TEST_CASE("a Lambert sphere decays at its exact rate, not at Eyring's") {
    constexpr float kRadius_m = 3;
    const Object sphere = test::icosphere(kRadius_m, 4);
    const double volume = test::volume_m3(sphere);
    const double surface = test::surface_m2(sphere);
    // The radius with the mesh's mean free path 4 V / S = 4 R / 3.
    const double radius_m = 3 * volume / surface;
    for (const float alpha : {0.3F, 0.5F}) {
        const Scene scene = test::grey_room(sphere, alpha, 1, Vec3(0), Vec3(0.5F, 0.2F, 0));
        const double c = double{scene.medium.speed_of_sound_m_s()};
        const double exact = sphere_decay(1 - double{alpha}) * c / (2 * radius_m);
        const double eyring = -std::log1p(-double{alpha}) * c * surface / (4 * volume);
        // From 8 mean free times on, over at most 40 dB.
        const double begin_s = 8 * 4 * radius_m / (3 * c);
        const test::Estimate e =
            decay_rate(scene, 0.3F, begin_s, begin_s + std::min(9 / exact, 0.28 - begin_s));
        CAPTURE(alpha, e.mean, e.standard_error, exact, eyring);
        CHECK(std::abs(e.mean - exact) < test::kFamilyZ * e.standard_error + 5e-4 * exact);
        CHECK(std::abs(e.z(eyring)) > test::kRefutedZ);  // Eyring is 2 to 4 % too fast
    }
}

TEST_CASE("Lambert boxes decay more slowly than Eyring by the known factors") {
    struct Case {
        Vec3 size;
        float alpha;
        double factor;  // T / T_Eyring
    };
    for (const Case& c : {Case{Vec3(4, 4, 4), 0.2F, 1.0433}, Case{Vec3(4, 4, 4), 0.3F, 1.0658},
                          Case{Vec3(5, 4, 3), 0.2F, 1.0444}, Case{Vec3(5, 4, 3), 0.3F, 1.0677}}) {
        const Object box = test::box(c.size);
        const Scene scene = test::grey_room(box, c.alpha, 1, 0.3F * c.size, 0.6F * c.size);
        const double eyring = -std::log1p(-double{c.alpha}) *
                              double{scene.medium.speed_of_sound_m_s()} * test::surface_m2(box) /
                              (4 * test::volume_m3(box));
        const test::Estimate e = decay_rate(scene, 0.45F, 0.1, 0.1 + std::min(9 / eyring, 0.32));
        CAPTURE(c.size.x, c.alpha, e.mean, e.standard_error, eyring);
        CHECK(std::abs(e.mean - eyring / c.factor) <
              test::kFamilyZ * e.standard_error + 1e-3 * eyring);
        CHECK(std::abs(e.z(eyring)) > test::kRefutedZ);  // a correct engine does not match Eyring
    }
}

TEST_CASE("a Lambert plane reflects rho P / (8 pi h^2), spread in time as r^-5") {
    constexpr float kHeight_m = 1;
    const Scene scene = test::grey_room(test::square(6), 0.2F, 1, Vec3(0.05F, 0.03F, kHeight_m),
                                        Vec3(0.05F, 0.03F, kHeight_m));
    Simulation simulation = patch(scene, 0.06F, 1, 0.1F);
    simulation.rays = 4000;
    Propagation propagation(scene, simulation);
    const double exact = 0.8 / (8 * kPi);
    const auto samples = test::restarts(propagation, scene, 24, 15, total);
    const test::Estimate e = test::estimate(samples);
    CAPTURE(e.mean, e.standard_error, exact);
    // The plane ends at 6 h, the response at 60 ms: less than 0.1 %; patches of 0.1 h: 0.3 %.
    CHECK(std::abs(e.mean - exact) < test::kFamilyZ * e.standard_error + 4e-3 * exact);
    CHECK(std::abs(e.z(1.03 * exact)) > test::kRefutedZ);  // companion
    // dE/dt = (c / 2) rho P h^2 / (2 pi r^5), r = ct / 2 >= h: beyond r it sums to (h / r)^4.
    const double c = double{scene.medium.speed_of_sound_m_s()};
    const auto beyond = test::restarts(propagation, scene, 24, 15, [&](const EnergyResponse& r) {
        return test::energy_between(r, 2 * 1.5 / c, 0.06);
    });
    const test::Estimate tail = test::estimate(beyond);
    CAPTURE(tail.mean, tail.standard_error);
    const double exact_tail = exact * (std::pow(1.5, -4) - std::pow(6, -4));
    // Bins of 1 ms and patches of 0.1 m smear the border by up to 0.1 m of 1.5 m, both ways.
    CHECK(std::abs(tail.mean - exact_tail) < test::kFamilyZ * tail.standard_error + 0.03 * exact);
}

TEST_CASE("a faceted sphere reflects as the smooth one, 1 / (4 pi (p + q + 2 p q / a)^2)") {
    // Source and listener at p and q from a mirror of radius a. The image source of a facet would
    // have a spreading of 1 / (4 pi (p + q)^2) at some points, and be silent at others.
    constexpr double kDistance_m = 1.5;
    constexpr auto kAt = static_cast<float>(1 + kDistance_m);
    for (const Estimator estimator : {Estimator::pt, Estimator::patch}) {
        std::vector<double> samples;
        for (int i = 0; i < 24; ++i) {
            // Each at other facets.
            const Vec3 direction =
                uniform_direction(RandomStream(derive_seed(test::test_seed(), i)).uniform_2d());
            Scene scene = test::grey_room(test::icosphere(1, 4), 0, 0, kAt * direction,
                                          (kAt + 1e-3F) * direction);
            scene.simulation.specular_order = 3;
            Simulation simulation = test::with(scene, estimator, 0.03F);
            simulation.rays = 4000;
            Propagation propagation(scene, simulation);
            double energy = 0;
            for (int f = 0; f < 10; ++f) {
                propagation.step(test::static_input(scene));
                if (estimator == Estimator::pt) energy += total(propagation.response(0)) / 10;
            }
            if (estimator == Estimator::patch) energy = total(propagation.response(0));
            for (const SoundPath& path : propagation.response(0).paths) {
                energy += double{path.energy[0]};
            }
            samples.push_back(energy);
        }
        const test::Estimate e = test::estimate(samples);
        const double exact =
            1 / (4 * kPi * std::pow(2 * kDistance_m + 2 * kDistance_m * kDistance_m, 2));
        CAPTURE(estimator_name(estimator), e.mean, e.standard_error, exact);
        // The mean over the listener's sphere is 1.3 % above that at its centre, the facets'
        // distance 0.1 % longer.
        CHECK(std::abs(e.mean - exact) < test::kFamilyZ * e.standard_error + 0.02 * exact);
        CHECK(std::abs(e.z(1.5 * exact)) > test::kRefutedZ);  // companion
    }
}

TEST_CASE("order 1 from the centre of a cube to its centre is 0.762761 rho P / a^2") {
    constexpr float kSide_m = 4;
    const Scene scene =
        test::grey_room(test::box(Vec3(kSide_m)), 0.25F, 1, Vec3(kSide_m / 2), Vec3(kSide_m / 2));
    Propagation propagation(scene, patch(scene, 0.1F, 1, 0.25F));
    const test::Estimate e = test::estimate(test::restarts(propagation, scene, 24, 15, total));
    const double exact = 0.762761 * 0.75 / double{kSide_m * kSide_m};
    CAPTURE(e.mean, e.standard_error, exact);
    CHECK(std::abs(e.mean - exact) < test::kFamilyZ * e.standard_error + 2e-3 * exact);
    CHECK(std::abs(e.z(1.03 * exact)) > test::kRefutedZ);  // companion
}

TEST_CASE("source and listener are interchangeable") {
    for (const float scattering : {1.0F, 0.3F}) {
        const Scene there = test::grey_room(test::l_shaped_room(), 0.2F, scattering,
                                            Vec3(5, 1.5F, 1.5F), Vec3(1.5F, 5, 1.2F));
        const Scene back = test::grey_room(test::l_shaped_room(), 0.2F, scattering,
                                           Vec3(1.5F, 5, 1.2F), Vec3(5, 1.5F, 1.5F));
        Propagation a(there, patch(there, 0.4F, 0));
        Propagation b(back, patch(back, 0.4F, 0));
        const test::Estimate one = test::estimate(test::restarts(a, there, 12, 5, total));
        const test::Estimate other = test::estimate(test::restarts(b, back, 12, 5, total));
        const double error = std::hypot(one.standard_error, other.standard_error);
        CAPTURE(scattering, one.mean, other.mean, error);
        // Patches of 0.5 m: 0.5 %.
        CHECK(std::abs(one.mean - other.mean) < test::kFamilyZ * error + 5e-3 * one.mean);
        CHECK(error < 0.02 * one.mean);  // companion: a difference would be detected
    }
}
