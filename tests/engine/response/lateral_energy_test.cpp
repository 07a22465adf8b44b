#include "engine/response/lateral_energy.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <random>

#include "engine/tail/directional_covariance.h"

namespace {

using namespace aula;

constexpr float kSpeed_m_s = 340;
const Vec3 kAxis(0, 1, 0);

EnergyResponse silence() { return EnergyResponse::silent(TimeBins(2.0), kSpeed_m_s); }

/// A path that arrives at a time at an angle to the axis.
SoundPath path(double time_s, double angle_rad, float energy, int order) {
    return {.order = order,
            .length_m = static_cast<float>(time_s) * kSpeed_m_s,
            .direction = {static_cast<float>(std::sin(angle_rad)),
                          static_cast<float>(std::cos(angle_rad)), 0},
            .energy = Bands::filled(energy)};
}

/// A response with one bin of energy 1 and the given directions, and direct sound before it.
EnergyResponse one_bin(const DirectionMoments& mean) {
    EnergyResponse response = silence();
    response.paths.push_back(path(0.01, std::numbers::pi / 2, 1, 0));
    const std::size_t bin = response.bins.index(0.03);
    response.energy[bin] = Bands::filled(1);
    response.directions[bin] = mean * Bands::filled(1).sum();
    return response;
}

}  // namespace

TEST_CASE("a reflection counts with the square of its cosine, and in J_LFC with the cosine") {
    const double angle_rad = 0.7;
    for (const double delay_s : {0.004, 0.006, 0.079, 0.081}) {
        INFO("delay " << delay_s);
        EnergyResponse response = silence();
        response.paths = {path(0.02, std::numbers::pi / 2, 2, 0),
                          path(0.02 + delay_s, angle_rad, 0.5F, 1)};
        const LateralParameters p = lateral_parameters(response, kAxis)[4];
        const double cosine = std::cos(angle_rad);
        const bool lateral = delay_s > 0.005 && delay_s < 0.08;
        const double early = delay_s < 0.08 ? 2.5 : 2;
        // Rounding of single precision.
        CHECK(*p.jlf == Approx(lateral ? 0.5 * cosine * cosine / early : 0).margin(1e-6));
        CHECK(*p.jlfc == Approx(lateral ? 0.5 * cosine / early : 0).margin(1e-6));
        CHECK(p.lj_db.has_value() == (delay_s > 0.08));
        if (p.lj_db) {
            CHECK(*p.lj_db ==
                  Approx(10 * std::log10(400 * std::numbers::pi * 0.5 * cosine * cosine))
                      .epsilon(1e-6));
        }
    }
}

TEST_CASE("a diffuse decay has the lateral parameters of the closed form") {
    // The energy exp(-r t) after the emission: a third of it is lateral, the mean cosine is 1/2.
    const double r = 13.8155 / 1.2;
    EnergyResponse response = silence();
    for (std::size_t i = 0; i < response.bins.count(); ++i)
        response.energy[i] = Bands::filled(static_cast<float>(
            std::exp(-r * response.bins.begin_s(i)) - std::exp(-r * response.bins.end_s(i))));
    const double early = 1 - std::exp(-r * 0.08);
    const double lateral = std::exp(-r * 0.005) - std::exp(-r * 0.08);
    const double late = std::exp(-r * 0.08) - std::exp(-r * response.bins.length_s());
    const LateralParameters p = lateral_parameters(response, kAxis)[2];
    // Bins end at 5 and 80 ms; rounding of floats, and 256 points of the quadrature.
    CHECK(*p.jlf == Approx(lateral / early / 3).epsilon(1e-4));
    CHECK(*p.jlfc == Approx(lateral / early / 2).epsilon(1e-4));
    CHECK(*p.lj_db == Approx(10 * std::log10(400 * std::numbers::pi * late / 3)).margin(0.001));
}

TEST_CASE("bins have the lateral energy of the figure of eight in ambisonic impulse responses") {
    const DirectionalCovariance covariance(1);
    std::vector<float> triangle(covariance.triangle());
    for (const Vec3& mean : {Vec3(0), Vec3(0.3F, 0.2F, 0.1F), Vec3(0, 0.6F, 0), Vec3(0, 0, 0.8F),
                             Vec3(0.5F, -0.5F, 0.5F), Vec3(0, 1, 0)}) {
        INFO("mean " << mean.x << ' ' << mean.y << ' ' << mean.z);
        const DirectionMoments moments = DirectionMoments::of(mean);
        covariance.mixing(moments, triangle.data());
        // Channel Y (ACN 1): the second row of the mixing matrix.
        const double y =
            double{triangle[1]} * double{triangle[1]} + double{triangle[2]} * double{triangle[2]};
        const LateralParameters p = lateral_parameters(one_bin(moments), kAxis)[3];
        CHECK(*p.jlf == Approx(y / 2).margin(1e-6));  // rounding
    }
    // Companion: the means differ.
    const EnergyResponse lateral = one_bin(DirectionMoments::of(Vec3(0, 1, 0)));
    CHECK(*lateral_parameters(lateral, kAxis)[3].jlf == Approx(0.5).margin(1e-6));
    CHECK(*lateral_parameters(one_bin({}), kAxis)[3].jlf == Approx(1 / 6.0).margin(1e-6));
}

TEST_CASE("the mean cosine of a horizontal or vertical field is near that of all its directions") {
    // The mean of |cos| over a circle is 2 / pi, of a plane perpendicular to the axis 0.
    const DirectionMoments horizontal{.xx = 1.0F / 6, .yy = 1.0F / 6};
    const LateralParameters p = lateral_parameters(one_bin(horizontal), kAxis)[3];
    CHECK(*p.jlf == Approx(0.5 / 2).margin(1e-6));
    CHECK(*p.jlfc == Approx(2 / std::numbers::pi / 2).margin(0.015));
    const DirectionMoments across{.xx = 1.0F / 6, .yy = -1.0F / 3};
    CHECK(*lateral_parameters(one_bin(across), kAxis)[3].jlfc == Approx(0).margin(1e-3));
}

TEST_CASE("the mean cosine of a bin is that of directions drawn around its mean") {
    // Directions u with a density proportional to exp(k u.v), drawn by rejection.
    std::mt19937 random(3);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> uniform;
    const double k = 2.5;
    const glm::dvec3 v = glm::normalize(glm::dvec3(1, 0.7, 0.2));
    constexpr int kDraws = 200'000;
    DirectionMoments mean;
    double magnitude = 0;
    for (int n = 0; n < kDraws;) {
        const glm::dvec3 u =
            glm::normalize(glm::dvec3(normal(random), normal(random), normal(random)));
        if (uniform(random) > std::exp(k * (glm::dot(u, v) - 1))) continue;
        mean += DirectionMoments::of(Vec3(u)) * (1.0F / kDraws);
        magnitude += std::abs(u.y) / kDraws;
        ++n;
    }
    const double length = 1 / std::tanh(k) - 1 / k;
    const LateralParameters p = lateral_parameters(one_bin(mean), kAxis)[0];
    // Statistical: |u.y| has a deviation of 0.3, 7e-4 in the mean; four of these.
    CHECK(glm::length(mean.intensity) == Approx(length).margin(0.005));
    CHECK(*p.jlfc == Approx(magnitude / 2).margin(0.0028 / 2));
}
