#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "aula/engine/propagation.h"
#include "tests/engine/tail/response_building.h"
#include "tests/support/measure.h"
#include "tests/support/rooms.h"

using namespace aula;
using namespace aula::test;

namespace {

/// A box whose walls differ.
struct UnevenBox {
    std::string name;
    glm::dvec3 size;
    std::array<double, 6> absorption;  ///< of the walls at z = 0, z = size, y = 0 .. x = size
    double scattering;
    glm::dvec3 source;
    glm::dvec3 listener;
};

const std::array<UnevenBox, 6>& boxes() {
    static const std::array<UnevenBox, 6> all{
        UnevenBox{"absorbing ceiling and floor, hard walls",
                  {7, 6, 3},
                  {0.3, 0.85, 0.04, 0.04, 0.04, 0.04},
                  0.1,
                  {2, 2, 1.5},
                  {5, 4, 1.2}},
        UnevenBox{"office",
                  {5, 4, 2.7},
                  {0.2, 0.7, 0.15, 0.1, 0.1, 0.1},
                  0.3,
                  {1.2, 1, 1.5},
                  {3.6, 2.8, 1.2}},
        UnevenBox{"corridor with absorbing walls",
                  {20, 2.5, 3},
                  {0.2, 0.2, 0.4, 0.4, 0.05, 0.05},
                  0.1,
                  {6, 1.2, 1.5},
                  {12, 1.4, 1.6}},
        UnevenBox{"hall with an audience",
                  {14, 10, 7},
                  {0.7, 0.08, 0.08, 0.08, 0.08, 0.15},
                  0.3,
                  {3, 5, 1.5},
                  {9, 4, 1.3}},
        UnevenBox{
            "curtain", {8, 6, 4}, {0.1, 0.1, 0.1, 0.1, 0.9, 0.05}, 0.2, {3, 2, 1.5}, {5, 4, 1.2}},
        UnevenBox{
            "shaft", {4, 4, 12}, {0.05, 0.05, 0.2, 0.2, 0.2, 0.2}, 0.2, {1, 1, 2}, {2.8, 2.6, 7}}};
    return all;
}

/// Second moments of directions, the means of x^2, y^2, z^2, in the bins of kWindows_s.
using Squares = std::array<glm::dvec3, 2>;
constexpr std::array<double, 3> kWindows_s{0.05, 0.1, 0.2};
constexpr double kSpeed_m_s = 343.2;

std::size_t window_of(double time_s) {
    const auto after = std::upper_bound(kWindows_s.begin(), kWindows_s.end(), time_s);
    return static_cast<std::size_t>(after - kWindows_s.begin()) - 1;  // before the first: huge
}

glm::dvec3 lambert(std::size_t axis, double inwards, std::mt19937_64& random) {
    std::uniform_real_distribution<double> uniform(0, 1);
    const double square = uniform(random);
    const double angle = 2 * std::numbers::pi * uniform(random);
    glm::dvec3 u;
    u[static_cast<int>(axis)] = inwards * std::sqrt(1 - square);
    u[static_cast<int>((axis + 1) % 3)] = std::sqrt(square) * std::cos(angle);
    u[static_cast<int>((axis + 2) % 3)] = std::sqrt(square) * std::sin(angle);
    return u;
}

/// The sound without the direct sound, by path tracing with the exact directions of what crosses a
/// small sphere.
Squares traced(const UnevenBox& box, int rays) {
    std::mt19937_64 random(test_seed());
    std::uniform_real_distribution<double> uniform(0, 1);
    std::normal_distribution<double> normal;
    const double radius_m = 0.07 * std::cbrt(box.size.x * box.size.y * box.size.z);
    Squares sums{};
    std::array<double, 2> all{};
    for (int ray = 0; ray < rays; ++ray) {
        glm::dvec3 at = box.source;
        glm::dvec3 u = glm::normalize(glm::dvec3(normal(random), normal(random), normal(random)));
        double energy = 1;
        double length_m = 0;
        for (int reflections = 0; length_m < kWindows_s.back() * kSpeed_m_s; ++reflections) {
            std::size_t axis = 0;
            double free_m = 1e9;
            for (std::size_t a = 0; a < 3; ++a) {
                const auto i = static_cast<int>(a);
                const double wall = u[i] > 0 ? box.size[i] : 0;
                const double distance_m = u[i] == 0 ? 1e9 : (wall - at[i]) / u[i];
                if (distance_m >= free_m) continue;
                free_m = distance_m;
                axis = a;
            }
            const double along_m = glm::dot(box.listener - at, u);
            const double off_m = glm::length(box.listener - at - along_m * u);
            if (reflections > 0 && off_m < radius_m && along_m > 0 && along_m < free_m) {
                const double half_m = std::sqrt(radius_m * radius_m - off_m * off_m);
                const std::size_t window = window_of((length_m + along_m) / kSpeed_m_s);
                if (window < sums.size()) {
                    sums[window] += energy * half_m * u * u;
                    all[window] += energy * half_m;
                }
            }
            const bool is_far = u[static_cast<int>(axis)] > 0;
            at += free_m * u;
            at[static_cast<int>(axis)] = is_far ? box.size[static_cast<int>(axis)] : 0;
            length_m += free_m;
            energy *= 1 - box.absorption[2 * (2 - axis) + (is_far ? 1U : 0U)];
            if (uniform(random) < box.scattering) {
                u = lambert(axis, is_far ? -1 : 1, random);
            } else {
                u[static_cast<int>(axis)] *= -1;
            }
        }
    }
    for (std::size_t w = 0; w < sums.size(); ++w) sums[w] /= all[w];
    return sums;
}

/// The room for the engine, without direct sound, image sources and air.
Scene scene_of(const UnevenBox& box) {
    Object object = test::box(Vec3(box.size));
    Scene scene = grey_room(object, 0.5F, static_cast<float>(box.scattering), Vec3(box.source),
                            Vec3(box.listener));
    scene.materials.clear();
    for (std::size_t wall = 0; wall < 6; ++wall) {
        scene.materials.push_back({"wall " + std::to_string(wall),
                                   Bands::filled(static_cast<float>(box.absorption[wall])),
                                   Bands::filled(static_cast<float>(box.scattering))});
        for (std::size_t triangle = 2 * wall; triangle < 2 * wall + 2; ++triangle)
            scene.objects[0].triangle_materials[triangle] = static_cast<std::uint32_t>(wall);
    }
    return scene;
}

EnergyResponse response_of(const Scene& scene, Estimator estimator, int rays, int frames) {
    Simulation simulation = with(scene, estimator, 0.25F);
    simulation.rays = rays;
    Propagation propagation(scene, simulation);
    for (int frame = 0; frame < frames; ++frame) propagation.step(static_input(scene));
    return propagation.response(0);
}

EnergyResponse response_of(const UnevenBox& box, Estimator estimator, int rays, int frames) {
    return response_of(scene_of(box), estimator, rays, frames);
}

Squares squares_of(const EnergyResponse& response) {
    Squares sums{};
    std::array<double, 2> all{};
    for (std::size_t k = 0; k < response.bins.count(); ++k) {
        const std::size_t window = window_of(response.bins.begin_s(k) + 1e-9);
        if (window >= sums.size()) continue;
        const DirectionMoments& m = response.directions[k];
        const double energy{response.energy[k].sum()};
        sums[window] += glm::dvec3(m.xx, m.yy, -m.xx - m.yy) + energy / 3;
        all[window] += energy;
    }
    for (std::size_t w = 0; w < sums.size(); ++w) sums[w] /= all[w];
    return sums;
}

/// Of the channels X, Y, Z of ambisonic responses, whose squares add up to that of W.
Squares squares_of_channels(const EnergyResponse& response, int order, int sources) {
    Squares sums{};
    for (int source = 0; source < sources; ++source) {
        ImpulseResponse ir;
        ImpulseResponseBuilder(test::carriers(1), kNoAir, 0.25, std::to_string(source), order)
            .build(response, ir);
        for (std::size_t n = 0; n < ir.channels[0].size(); ++n) {
            const std::size_t window = window_of(static_cast<double>(n) / kRate_hz);
            if (window >= sums.size()) continue;
            const glm::dvec3 u(ir.channels[3][n], ir.channels[1][n], ir.channels[2][n]);
            sums[window] += u * u;
        }
    }
    for (glm::dvec3& sum : sums) sum /= sum.x + sum.y + sum.z;
    return sums;
}

double worst(const Squares& a, const Squares& b) {
    double largest = 0;
    for (std::size_t w = 0; w < a.size(); ++w)
        for (int axis = 0; axis < 3; ++axis)
            largest = std::max(largest, std::abs(a[w][axis] - b[w][axis]));
    return largest;
}

std::string text(const Squares& squares) {
    std::string text;
    for (const glm::dvec3& s : squares) {
        for (int axis = 0; axis < 3; ++axis) text += std::to_string(s[axis]).substr(0, 5) + ' ';
        text += "  ";
    }
    return text;
}

}  // namespace

TEST_CASE("responses and their tails have the second moments of the directions of path tracing") {
    // Statistical: some 1000 independent arrivals in a window, and squares with a deviation of 0.3:
    // 0.01, and as much of the rays of the engine. A channel of a window of 50 ms has 2400 samples,
    // of 20 sources 48,000: 0.003. What is rendered has the times of bins and linear envelopes,
    // which move some energy across the edges of windows.
    for (const UnevenBox& box : boxes()) {
        INFO(box.name);
        const Squares truth = traced(box, 200'000);
        const EnergyResponse response = response_of(box, Estimator::patch, 1000, 30);
        const Squares engine = squares_of(response);
        const Squares rendered = squares_of_channels(response, 1, 20);
        INFO("traced " << text(truth) << "engine " << text(engine) << "rendered "
                       << text(rendered));
        CHECK(worst(engine, truth) < 0.04);
        CHECK(worst(rendered, truth) < 0.05);
    }
    // Companion: a diffuse field is detected.
    CHECK(worst(traced(boxes()[0], 20'000), {glm::dvec3(1.0 / 3), glm::dvec3(1.0 / 3)}) > 0.25);
}

TEST_CASE("the second moments of path tracing and of rays from the listener are the same") {
    const UnevenBox& box = boxes()[1];
    const Squares truth = traced(box, 60'000);
    for (const Estimator estimator : {Estimator::pt, Estimator::dpc}) {
        INFO("estimator " << static_cast<int>(estimator));
        CHECK(worst(squares_of(response_of(box, estimator, 20'000, 1)), truth) < 0.05);
    }
    const Scene scene = scene_of(box);
    Simulation simulation = with(scene, Estimator::patch, 0.25F);
    simulation.rays = 4000;
    Propagation propagation(scene, simulation);
    propagation.emit_from_listeners();
    for (int frame = 0; frame < 30; ++frame) propagation.step(static_input(scene));
    CHECK(worst(squares_of(propagation.response(0)), truth) < 0.05);
}

TEST_CASE("tails of the third order have the second moments as those of the first") {
    const EnergyResponse response = response_of(boxes()[0], Estimator::patch, 1000, 30);
    // Statistical, as above: different carriers.
    CHECK(worst(squares_of_channels(response, 3, 8), squares_of_channels(response, 1, 8)) < 0.02);
}

TEST_CASE("the moments of all octaves are the mean of theirs") {
    const auto height = [](const Bands& ceiling) {
        Scene scene = scene_of(boxes()[0]);
        scene.materials[1].absorption = ceiling;
        return squares_of(response_of(scene, Estimator::patch, 1000, 30))[0].z;
    };
    const double bass = height(Bands::filled(0.2F));
    const double treble = height(Bands::filled(0.9F));
    const double all = height({{0.2F, 0.3F, 0.5F, 0.7F, 0.85F, 0.9F, 0.9F, 0.9F}});
    CHECK(bass - all > 0.03);
    CHECK(bass - all < 0.1);
    CHECK(all - treble > 0.05);
    CHECK(all - treble < 0.1);
}
