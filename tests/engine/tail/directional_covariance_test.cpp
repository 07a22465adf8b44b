#include "engine/tail/directional_covariance.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <random>
#include <vector>

#include "aula/engine/impulse_response.h"
#include "engine/base/spherical_harmonics.h"

using namespace aula;

namespace {

using Matrix = std::vector<std::vector<double>>;

/// Uniformly distributed directions.
std::vector<Vec3> lattice(int count) {
    std::vector<Vec3> directions;
    for (int i = 0; i < count; ++i) {
        const double z = 1 - (2.0 * i + 1) / count;
        const double azimuth = std::numbers::pi * (3 - std::sqrt(5.0)) * i;
        const double r = std::sqrt(1 - z * z);
        directions.emplace_back(r * std::cos(azimuth), r * std::sin(azimuth), z);
    }
    return directions;
}

/// The covariance of the channels for given moments.
Matrix covariance(const DirectionalCovariance& field, const DirectionMoments& moments) {
    std::vector<float> triangle(field.triangle());
    field.mixing(moments, triangle.data());
    const std::size_t n = field.channels();
    Matrix lower(n, std::vector<double>(n));
    for (std::size_t i = 0, k = 0; i < n; ++i)
        for (std::size_t j = 0; j <= i; ++j) lower[i][j] = double{triangle[k++]};
    Matrix c(n, std::vector<double>(n));
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = 0; j < n; ++j)
            for (std::size_t k = 0; k < n; ++k) c[i][j] += lower[i][k] * lower[j][k];
    return c;
}

int order_of(std::size_t channel) { return static_cast<int>(std::sqrt(double(channel) + 0.5)); }

/// Moments and covariance of channels.
struct Field {
    DirectionMoments moments;
    Matrix covariance;
};

/// Of a density.
template <typename Density>
Field distributed(const Density& density) {
    Field field{{}, Matrix(16, std::vector<double>(16))};
    std::array<double, 9> low{};
    for (const Vec3& u : lattice(20000)) {
        std::array<double, 16> y;
        spherical_harmonics(u, 3, y.data());
        const double p = density(u);
        for (std::size_t i = 0; i < low.size(); ++i) low[i] += p * y[i];
        for (std::size_t i = 0; i < 16; ++i)
            for (std::size_t j = 0; j < 16; ++j) field.covariance[i][j] += p * y[i] * y[j];
    }
    for (auto& row : field.covariance)
        for (double& x : row) x /= low[0];
    const auto mean = [&](std::size_t i) { return static_cast<float>(low[i] / low[0]); };
    const float root3 = std::sqrt(3.0F);
    field.moments.intensity = Vec3(mean(3), mean(1), mean(2));
    field.moments.xx = mean(8) / root3 - mean(6) / 3;
    field.moments.yy = -mean(8) / root3 - mean(6) / 3;
    field.moments.xy = mean(4) / root3;
    field.moments.yz = mean(5) / root3;
    field.moments.zx = mean(7) / root3;
    return field;
}

double worst_difference(const Matrix& a, const Matrix& b) {
    double worst = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        for (std::size_t j = 0; j < a.size(); ++j)
            worst = std::max(worst, std::abs(a[i][j] - b[i][j]));
    return worst;
}

}  // namespace

TEST_CASE("harmonics have the AmbiX convention and are orthogonal with energies 1 / (2 l + 1)") {
    const auto directions = lattice(20000);
    Matrix products(49, std::vector<double>(49));
    for (const Vec3& u : directions) {
        std::array<double, 49> y;
        spherical_harmonics(u, 6, y.data());
        for (std::size_t i = 0; i < 49; ++i)
            for (std::size_t j = 0; j < 49; ++j)
                products[i][j] += y[i] * y[j] / static_cast<double>(directions.size());
    }
    Matrix expected(49, std::vector<double>(49));
    for (std::size_t i = 0; i < 49; ++i) expected[i][i] = 1.0 / (2 * order_of(i) + 1);
    CHECK(worst_difference(products, expected) < 1e-3);  // error of the lattice, about 1 / points

    std::array<double, 16> y;
    const Vec3 u(0.48F, -0.6F, 0.64F);
    spherical_harmonics(u, 3, y.data());
    const double root3 = std::sqrt(3.0);
    const double x = 0.48, z = 0.64;
    const std::array<double, 9> low{1,
                                    -0.6,
                                    z,
                                    x,
                                    root3 * x * -0.6,
                                    root3 * -0.6 * z,
                                    (3 * z * z - 1) / 2,
                                    root3 * x * z,
                                    root3 / 2 * (x * x - 0.36)};
    for (std::size_t i = 0; i < low.size(); ++i) CHECK(y[i] == Approx(low[i]).margin(1e-6));
    CHECK(y[15] == Approx(std::sqrt(5.0 / 8) * x * (x * x - 3 * 0.36)).margin(1e-6));
}

TEST_CASE("a diffuse field's channels are uncorrelated with energies 1 / (2 l + 1)") {
    for (int order = 0; order <= 3; ++order) {
        const DirectionalCovariance field(order);
        Matrix expected(field.channels(), std::vector<double>(field.channels()));
        for (std::size_t i = 0; i < expected.size(); ++i)
            expected[i][i] = 1.0 / (2 * order_of(i) + 1);
        CHECK(worst_difference(covariance(field, {}), expected) < 1e-6);  // rounding
    }
}

TEST_CASE("sound from one direction has the covariance of a plane wave") {
    const DirectionalCovariance field(3);
    // Rounding of single precision, 6e-8, in harmonics up to degree 6, whose slopes are up to
    // P_6'(1) = 21, with the factors 2 l + 1 up to 13; what is left out as rounding is below 1e-5.
    constexpr double kBound = 2e-5;
    for (const Vec3& u : lattice(2000)) {
        std::array<double, 16> y;
        spherical_harmonics(u, 3, y.data());
        Matrix expected(16, std::vector<double>(16));
        for (std::size_t i = 0; i < 16; ++i)
            for (std::size_t j = 0; j < 16; ++j) expected[i][j] = y[i] * y[j];
        CHECK(worst_difference(covariance(field, DirectionMoments::of(u)), expected) < kBound);
    }
}

TEST_CASE("partly directed sound has the covariance of a von Mises-Fisher distribution") {
    const DirectionalCovariance field(3);
    for (const double concentration : {0.3, 2.0, 9.0, 40.0}) {
        const Vec3 axis = glm::normalize(Vec3(0.3F, -0.8F, 0.5F));
        const Field expected = distributed([&](const Vec3& u) {
            return std::exp(concentration * (double{glm::dot(u, axis)} - 1));
        });
        CAPTURE(concentration);
        // The table over |mean| has 256 steps.
        CHECK(worst_difference(covariance(field, expected.moments), expected.covariance) < 3e-3);
        // Companion: a different spread is detected.
        CHECK(worst_difference(covariance(field, expected.moments * 0.9F), expected.covariance) >
              3e-3);
    }
}

TEST_CASE("sound about a plane or an axis has the covariance of Watson's distribution") {
    const DirectionalCovariance field(3);
    for (const double concentration : {-30.0, -5.0, -1.0, 1.0, 5.0, 30.0}) {
        const Vec3 axis = glm::normalize(Vec3(0.3F, -0.8F, 0.5F));
        const Field expected = distributed([&](const Vec3& u) {
            return std::exp(concentration * std::pow(double{glm::dot(u, axis)}, 2));
        });
        CAPTURE(concentration);
        CHECK(worst_difference(covariance(field, expected.moments), expected.covariance) < 3e-3);
    }
}

TEST_CASE("sound that arrives unequally along three axes has nearly Bingham's covariance") {
    // The distribution of greatest entropy, here with a mean. The sum of two of Watson's is near
    // it.
    const DirectionalCovariance field(3);
    const Field expected = distributed([](const Vec3& u) {
        const glm::dvec3 v(u);
        return std::exp(1.5 * v.x * v.x - 6 * v.z * v.z + v.x * v.y + 0.4 * v.y - 0.2 * v.x);
    });
    CHECK(worst_difference(covariance(field, expected.moments), expected.covariance) < 0.06);
    // Companion: with the mean alone.
    CHECK(worst_difference(covariance(field, {.intensity = expected.moments.intensity}),
                           expected.covariance) > 0.2);
}

TEST_CASE("channels of any directions have the moments and the energy of their order") {
    std::mt19937 random(1);
    std::normal_distribution<float> normal;
    std::uniform_real_distribution<float> uniform(0, 1);
    const DirectionalCovariance field(3);
    for (int trial = 0; trial < 300; ++trial) {
        DirectionMoments moments;
        const int arrivals = 1 + trial % 7;
        float sum = trial % 2 == 0 ? 0.0F : uniform(random);  // diffuse
        for (int i = 0; i < arrivals; ++i) {
            const float energy = uniform(random);
            const Vec3 u(normal(random), normal(random), normal(random));
            moments += DirectionMoments::of(glm::normalize(u)) * energy;
            sum += energy;
        }
        moments *= 1 / sum;
        const Matrix c = covariance(field, moments);
        CAPTURE(trial);
        // Rounding; pivots below 1e-5 are left out, with covariances of up to their root.
        REQUIRE(c[0][0] == Approx(1).margin(1e-6));
        REQUIRE(c[1][0] == Approx(double{moments.intensity.y}).margin(1e-4));
        REQUIRE(c[2][0] == Approx(double{moments.intensity.z}).margin(1e-4));
        REQUIRE(c[3][0] == Approx(double{moments.intensity.x}).margin(1e-4));
        REQUIRE(c[1][1] == Approx(1.0 / 3 + double{moments.yy}).margin(1e-4));
        REQUIRE(c[3][3] == Approx(1.0 / 3 + double{moments.xx}).margin(1e-4));
        REQUIRE(c[2][1] == Approx(double{moments.yz}).margin(3e-3));
        REQUIRE(c[3][1] == Approx(double{moments.xy}).margin(3e-3));
        for (int order = 1; order <= 3; ++order) {
            double energy = 0;
            for (int i = order * order; i < (order + 1) * (order + 1); ++i)
                energy += c[static_cast<std::size_t>(i)][static_cast<std::size_t>(i)];
            CAPTURE(order);
            REQUIRE(energy == Approx(1).margin(5e-4));
        }
    }
}

TEST_CASE("moments that no distribution has give finite channels without more energy") {
    const DirectionalCovariance field(3);
    for (const DirectionMoments& moments :
         {DirectionMoments{.intensity = Vec3(0, 0, 1)}, DirectionMoments{.xx = -0.5F, .yy = 0.1F},
          DirectionMoments{.intensity = Vec3(0.7F, 0, 0.7F), .xx = 0.4F, .yz = 0.6F}}) {
        const Matrix c = covariance(field, moments);
        for (std::size_t i = 0; i < c.size(); ++i) {
            CAPTURE(i);
            CHECK(std::isfinite(c[i][i]));
            CHECK(c[i][i] <= 1 + 1e-5);
        }
    }
}

TEST_CASE("the covariance of the first-order channels with W is the mean direction") {
    const DirectionalCovariance field(2);
    const Vec3 u = glm::normalize(Vec3(2, 5, -3));
    const Matrix c = covariance(field, DirectionMoments::of(u) * 0.7F);
    CHECK(c[0][0] == Approx(1).margin(1e-6));
    CHECK(c[1][0] == Approx(0.7 * double{u.y}).margin(1e-6));
    CHECK(c[2][0] == Approx(0.7 * double{u.z}).margin(1e-6));
    CHECK(c[3][0] == Approx(0.7 * double{u.x}).margin(1e-6));
    // The energies of each order sum to that of W for any directions.
    CHECK(c[1][1] + c[2][2] + c[3][3] == Approx(1).margin(1e-6));
    CHECK(c[4][4] + c[5][5] + c[6][6] + c[7][7] + c[8][8] == Approx(1).margin(1e-6));
}

TEST_CASE("the channels of orders with the same plane waves are the same") {
    EnergyResponse r = EnergyResponse::silent(TimeBins(0.3));
    for (std::size_t i = 0; i < r.bins.count(); ++i) {
        r.energy[i] = Bands::filled(1);
        r.directions[i] =
            DirectionMoments::of(Vec3(0.1F * static_cast<float>(i % 7), 0.2F, 0.3F)) * 8;
    }
    std::vector<ImpulseResponse> responses(4);
    const auto carriers = aula::make_noise_carriers(48000, 1);
    for (int order = 0; order <= 3; ++order)
        ImpulseResponseBuilder(carriers, Medium{}, 0.3, "source", order)
            .build(r, responses[static_cast<std::size_t>(order)]);
    for (const std::size_t order : {0U, 2U}) {
        const auto& low = responses[order].channels;
        const auto& high = responses[order + 1].channels;
        REQUIRE(low.size() == (order + 1) * (order + 1));
        for (std::size_t c = 0; c < low.size(); ++c) {
            double worst = 0;
            double loudest = 0;
            for (std::size_t n = 0; n < low[c].size(); ++n) {
                worst = std::max(worst, double{std::abs(low[c][n] - high[c][n])});
                loudest = std::max(loudest, double{std::abs(low[c][n])});
            }
            CHECK(worst < 1e-5 * loudest);  // rounding
        }
    }
}
