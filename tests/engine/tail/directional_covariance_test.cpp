#include "engine/tail/directional_covariance.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
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

/// The covariance of the channels for a mean direction.
Matrix covariance(const DirectionalCovariance& field, const Vec3& mean) {
    std::vector<float> triangle(field.triangle());
    field.mixing(mean, triangle.data());
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
        CHECK(worst_difference(covariance(field, Vec3{0}), expected) < 1e-6);  // rounding
    }
}

TEST_CASE("sound from one direction has the covariance of a plane wave") {
    const DirectionalCovariance field(3);
    // The covariance with W is Y_i. Of the harmonics up to order 3, P_3 has the steepest slope over
    // the length of the direction: P_3'(1) = 6. Rounding changes the length by 3.5 units in |mean|,
    // which the moments follow, as many in the division, and one in `u`. Products have twice the
    // error.
    constexpr double kUnit = 0x1p-24;  // of single precision
    constexpr double kBound = 2 * 6 * (3.5 + 3.5 + 1) * kUnit;
    for (const Vec3& u : lattice(2000)) {
        std::array<double, 16> y;
        spherical_harmonics(u, 3, y.data());
        Matrix expected(16, std::vector<double>(16));
        for (std::size_t i = 0; i < 16; ++i)
            for (std::size_t j = 0; j < 16; ++j) expected[i][j] = y[i] * y[j];
        CHECK(worst_difference(covariance(field, u), expected) < kBound);
    }
}

TEST_CASE("partly directed sound has the covariance of a von Mises-Fisher distribution") {
    const DirectionalCovariance field(3);
    const auto directions = lattice(20000);
    for (const double concentration : {0.3, 2.0, 9.0, 40.0}) {
        const Vec3 axis = glm::normalize(Vec3(0.3F, -0.8F, 0.5F));
        Matrix expected(16, std::vector<double>(16));
        Vec3 mean{0};
        double sum = 0;
        for (const Vec3& u : directions) {
            std::array<double, 16> y;
            spherical_harmonics(u, 3, y.data());
            const double p = std::exp(concentration * (double{glm::dot(u, axis)} - 1));
            sum += p;
            mean += u * static_cast<float>(p);
            for (std::size_t i = 0; i < 16; ++i)
                for (std::size_t j = 0; j < 16; ++j) expected[i][j] += p * y[i] * y[j];
        }
        for (auto& row : expected)
            for (double& x : row) x /= sum;
        CAPTURE(concentration);
        // The table over |mean| has 256 steps.
        CHECK(worst_difference(covariance(field, mean / static_cast<float>(sum)), expected) < 3e-3);
        // Companion: a different spread is detected.
        CHECK(worst_difference(covariance(field, mean / static_cast<float>(0.9 * sum)), expected) >
              3e-3);
    }
}

TEST_CASE("the covariance of the first-order channels with W is the mean direction") {
    const DirectionalCovariance field(2);
    const Vec3 mean(0.2F, 0.5F, -0.3F);
    const Matrix c = covariance(field, mean);
    CHECK(c[0][0] == Approx(1).margin(1e-6));
    CHECK(c[1][0] == Approx(0.5).margin(1e-6));
    CHECK(c[2][0] == Approx(-0.3).margin(1e-6));
    CHECK(c[3][0] == Approx(0.2).margin(1e-6));
    // The energies of each order sum to that of W for any directions.
    CHECK(c[1][1] + c[2][2] + c[3][3] == Approx(1).margin(1e-6));
    CHECK(c[4][4] + c[5][5] + c[6][6] + c[7][7] + c[8][8] == Approx(1).margin(1e-6));
}

TEST_CASE("the channels of orders with the same plane waves are the same") {
    EnergyResponse r = EnergyResponse::silent(TimeBins(0.3));
    for (std::size_t i = 0; i < r.bins.count(); ++i) {
        r.energy[i] = Bands::filled(1);
        r.intensity[i] = Vec3(0.1F * static_cast<float>(i % 7), 0.2F, 0) * 8.0F;
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
