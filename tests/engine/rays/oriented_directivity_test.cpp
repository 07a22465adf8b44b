#include "engine/rays/oriented_directivity.h"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "aula/engine/scene.h"
#include "engine/base/sampling.h"

using namespace aula;

namespace {

OrientedDirectivity oriented(const char* name, const Pose& pose) {
    return {std::make_shared<EmissionSampler>(*Directivity::find(name)), pose.rotation()};
}

/// Mean energy and mean energy flux of the rays of a source, in a band.
struct Emission {
    double power = 0;
    glm::dvec3 flux{0};
    double largest = 0;
};

Emission emission(const OrientedDirectivity& directivity, std::size_t band, bool weighted) {
    constexpr std::uint32_t kRays = 1U << 14;
    const ScrambledSobol points(1);
    Emission sum;
    for (std::uint32_t i = 0; i < kRays; ++i) {
        const auto [direction, energy] = directivity.sample(points.point(i));
        const double e = weighted ? double{energy[band]} : 1;
        sum.power += e / kRays;
        sum.flux += e / kRays * glm::dvec3(direction);
        sum.largest = std::max(sum.largest, e);
    }
    return sum;
}

}  // namespace

TEST_CASE("emitted rays have the power and the flux of the directivity in each band") {
    // A cardioid has the flux 1/2 to the front, a figure of eight 0: integrals of D cos(theta) / 2.
    // 16384 points of low discrepancy: errors of about 1e-4 times the variation of the energies.
    constexpr double kError = 2e-3;
    const Pose pose{Vec3(0), 1.1F, -0.5F, 0.3F};
    const glm::dvec3 front(pose.rotation()[0]);
    const OrientedDirectivity cardioid = oriented("cardioid", pose);
    const Emission rays = emission(cardioid, 2, true);
    CHECK(std::abs(rays.power - 1) < kError);
    CHECK(glm::distance(rays.flux, 0.5 * front) < kError);
    const Emission eight = emission(oriented("figure_of_eight", pose), 2, true);
    CHECK(std::abs(eight.power - 1) < kError);
    CHECK(glm::length(eight.flux) < kError);
    // A talker's bands differ; all are carried by the same rays, whose energies stay bounded: the
    // density is at least 0.9 times an eighth of a band's factor.
    for (std::size_t b = 0; b < kBandCount; ++b) {
        const Emission talker = emission(oriented("talker", pose), b, true);
        CAPTURE(b);
        CHECK(std::abs(talker.power - 1) < kError);
        CHECK(talker.largest < kBandCount / 0.9);
    }
    // Companions: rays of equal energies have a flux, but not that of all bands; those of the
    // density alone miss the flux of a cardioid, as a tenth of them is uniform.
    CHECK(glm::distance(emission(cardioid, 2, false).flux, 0.5 * front) > 10 * kError);
    CHECK(glm::distance(emission(oriented("talker", pose), 0, false).flux,
                        emission(oriented("talker", pose), 0, true).flux) > 10 * kError);
}

TEST_CASE("emitted rays have no preferred azimuths and heights") {
    // A cardioid on the x axis has no harmonics of a high order in the azimuth about z or in z;
    // rays in a regular grid have. The errors are those of 16384 points, see above.
    const OrientedDirectivity cardioid = oriented("cardioid", {});
    constexpr std::uint32_t kRays = 1U << 14;
    const ScrambledSobol points(1);
    for (const int order : {32, 64, 96, 128, 160, 256}) {
        std::array<double, 2> azimuth{};
        std::array<double, 2> height{};
        for (std::uint32_t i = 0; i < kRays; ++i) {
            const auto [direction, energy] = cardioid.sample(points.point(i));
            const double turn_rad = order * double{std::atan2(direction.y, direction.x)};
            const double rise_rad = order * std::numbers::pi * double{direction.z};
            azimuth[0] += double{energy[2]} / kRays * std::cos(turn_rad);
            azimuth[1] += double{energy[2]} / kRays * std::sin(turn_rad);
            height[0] += double{energy[2]} / kRays * std::cos(rise_rad);
            height[1] += double{energy[2]} / kRays * std::sin(rise_rad);
        }
        CAPTURE(order);
        CHECK(std::hypot(azimuth[0], azimuth[1]) < 0.05);
        CHECK(std::hypot(height[0], height[1]) < 0.05);
    }
}

TEST_CASE("a turn counts as a movement by the change of the directivity") {
    const auto turned_m = [](const char* name, const Pose& from, const Pose& to) {
        return oriented(name, to).turned_m(oriented(name, from));
    };
    const Pose front;
    const Pose left{Vec3(0), 1.5707964F, 0, 0};
    const Pose rear{Vec3(0), 3.1415927F, 0, 0};
    CHECK(turned_m("cardioid", front, front) == 0);
    // The mean of |D(u) - D(-u)| = 3 |cos| over the sphere.
    CHECK(turned_m("cardioid", front, rear) == Approx(1.5).epsilon(0.01));  // 128 directions
    CHECK(turned_m("cardioid", front, left) > 0.5);
    CHECK(turned_m("subcardioid", front, rear) < turned_m("cardioid", front, rear));
    // A figure of eight has the same energies to the rear; the turn is nevertheless a change.
    CHECK(turned_m("figure_of_eight", front, rear) > 0);
    CHECK(turned_m("figure_of_eight", front, rear) < 1e-4);
    CHECK(OrientedDirectivity(nullptr, left.rotation()).turned_m({}) == 0);
}
