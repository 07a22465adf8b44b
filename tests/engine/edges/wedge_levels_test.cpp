// Levels behind half planes and wedges: means of octaves, and the insertion loss of a barrier.

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <glm/geometric.hpp>
#include <numbers>
#include <vector>

#include "engine/edges/wedge_integral.h"
#include "tests/engine/direct/edge_path_scene.h"

namespace wedge_levels_test {

using aula::ComplexBands;
using aula::kBandCount;
using aula::Vec3;
using aula::WedgeField;
using aula::WedgeIntegral;
using aula::WedgePoint;
using aula::test::EdgePathScene;
using aula::test::half_plane;
using aula::test::Levels;

namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kDegree = kPi / 180;
constexpr double kSpeed_m_s = 343.2;

// The formula errs by 0.02 dB, and the lists have one decimal.
constexpr double kFormula_db = 0.07;

struct OctaveCase {
    const char* name;
    double open_degrees;
    double source_degrees;
    double receiver_degrees;
    Levels level_db;
};

// Source and receiver are 2 m from the edge. H6 and W4 are on the boundary of the shadow.
const std::vector<OctaveCase> kOctaves{
    {"H6", 360, 90, 270, {-3.7, -4.4, -4.9, -5.2, -5.5, -5.6, -5.7, -5.8}},
    {"W4", 270, 45, 225, {-1.0, -2.0, -3.0, -3.9, -4.5, -4.9, -5.3, -5.5}},
    {"W9", 300, 45, 280, {-5.3, -7.3, -9.8, -12.5, -15.4, -18.4, -21.4, -24.4}},
    {"W10", 210, 20, 205, {3.0, 2.2, 1.2, 0.0, -1.4, -2.9, -4.7, -6.6}},
};

/// Mean energy in each octave of the field in the shadow, relative to free field. The terms of the
/// faces' reflections may be left out.
Levels octave_db(const OctaveCase& c, bool with_reflections) {
    const double turn_rad = (c.receiver_degrees - c.source_degrees) * kDegree;
    const double free_m = 4 * std::sin(turn_rad / 2);
    // A little beyond the boundary, where the direct sound has ended.
    const double beyond_rad = std::abs(turn_rad - kPi) < 1e-9 ? 1e-7 : 0;
    const WedgePoint source{2, c.source_degrees * kDegree, 0};
    const WedgePoint receiver{2, c.receiver_degrees * kDegree + beyond_rad, 0};
    constexpr int kSteps = 200;
    Levels energy{};
    for (int step = 0; step < kSteps; ++step) {
        // WedgeIntegral has the centres of the octaves: other frequencies are other speeds.
        const double scale = std::exp2((step + 0.5) / kSteps - 0.5);
        const WedgeField field =
            WedgeIntegral(kSpeed_m_s / scale).field({c.open_degrees * kDegree}, source, receiver);
        const ComplexBands sum = with_reflections ? field.total() : field.incident;
        // White noise: the steps are in proportion to the frequency.
        const double weight = scale * std::numbers::ln2 * std::numbers::sqrt2 / kSteps;
        for (std::size_t b = 0; b < kBandCount; ++b)
            energy[b] += weight * std::norm(sum[b] * free_m);
    }
    Levels level;
    for (std::size_t b = 0; b < kBandCount; ++b) level[b] = 10 * std::log10(energy[b]);
    return level;
}

struct InsertionLoss {
    double distance_m;  ///< of source and receiver from the edge
    double fresnel_number;
    double loss_db;
};

// A half plane across the line between source and receiver, at 1 kHz: Biot and Tolstoy's closed
// form.
const std::vector<InsertionLoss> kInsertionLosses{
    {10, 0.01, 6.9}, {10, 0.03, 7.8}, {10, 0.1, 9.3}, {10, 0.3, 11.6}, {10, 1, 15.3},
    {10, 3, 19.2},   {10, 10, 23.6},  {10, 30, 28.3}, {2, 0.01, 6.5},  {2, 0.03, 7.3},
    {2, 0.1, 8.8},   {2, 0.3, 10.9},  {2, 1, 14.3},   {2, 3, 18.2},    {2, 10, 24.6},
};
constexpr std::size_t k1kHz = 4;

}  // namespace

TEST_CASE("half planes and wedges: the mean energy of every octave") {
    for (const OctaveCase& c : kOctaves) {
        const Levels level = octave_db(c, true);
        const Levels incident = octave_db(c, false);
        double without_reflections_db = 0;
        for (std::size_t b = 0; b < kBandCount; ++b) {
            CAPTURE(c.name, b);
            CHECK(level[b] == Approx(c.level_db[b]).margin(kFormula_db));
            without_reflections_db =
                std::max(without_reflections_db, std::abs(incident[b] - c.level_db[b]));
        }
        // Companion: a screen that does not reflect has -6 dB at all frequencies on the boundary.
        CHECK(without_reflections_db > 1);
    }
}

TEST_CASE("a half plane has the insertion loss of the exact solution, not of measured barriers") {
    // The edges that stand for infinite ones end 50 m away.
    const EdgePathScene place({half_plane()});
    for (const InsertionLoss& c : kInsertionLosses) {
        CAPTURE(c.distance_m, c.fresnel_number);
        const double detour_m = c.fresnel_number * kSpeed_m_s / 1000 / 2;
        const double bend_rad = std::acos(1 - detour_m / (2 * c.distance_m));  // half of it
        const double free_m = 2 * c.distance_m * std::cos(bend_rad);
        const double angle_rad = kPi / 2 - bend_rad;
        const ComplexBands field =
            WedgeIntegral(kSpeed_m_s)
                .field({}, {c.distance_m, angle_rad, 0}, {c.distance_m, 2 * kPi - angle_rad, 0})
                .total();
        const double loss_db = -20 * std::log10(std::abs(field[k1kHz]) * free_m);
        CHECK(loss_db == Approx(c.loss_db).margin(kFormula_db));
        // The wall is x < 0 in the plane y = 0.
        const auto below_m = static_cast<float>(c.distance_m * std::sin(bend_rad));
        const auto across_m = static_cast<float>(free_m / 2);
        const Levels level =
            place.coherent_db(Vec3(-below_m, -across_m, 0), Vec3(-below_m, across_m, 0));
        CHECK(-level[k1kHz] == Approx(c.loss_db).margin(0.2));
        // Companion: the fit of Kurze and Anderson to Maekawa's measurements.
        const double x = std::sqrt(2 * kPi * c.fresnel_number);
        CHECK(std::abs(5 + 20 * std::log10(x / std::tanh(x)) - c.loss_db) > 0.3);
    }
}

}  // namespace wedge_levels_test
